/// @file
/// What can be archived, and what its records say of it.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Bytes that are no checkpoint of this object, and why. Whatever throws it has changed nothing.
class CheckpointError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Writer;

/// An object that is read member by member, because it is too large to be copied or refers to others: it says
/// `using ArchivedByParts = void;`, and its archive(ar) names members alone, what isn't one by ar.aside(…).
template <class T>
concept ByParts = requires {
  typename T::ArchivedByParts;
};
/// An object that holds more than a checkpoint does (Jacobians, factors), and forgets that after a save, as it does after a load:
/// the run that saved and the run that resumes are then the same.
template <class T>
concept HasUnsaved = requires(T& x) {
  x.forget_unsaved();
};

namespace detail {
template <class T>
inline constexpr bool is_name = std::is_same_v<std::decay_t<T>, const char*> || std::is_same_v<std::decay_t<T>, char*>;
template <class T>
inline constexpr bool is_list = false;
template <class T, class A>
inline constexpr bool is_list<std::vector<T, A>> = true;
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class T>
concept Archived = requires(T& x, Writer& ar) {
  x.archive(ar);
};
template <class T>
concept Dense = std::is_base_of_v<Eigen::DenseBase<T>, T>;
template <class T>
concept Blocked = requires(T& x) {
  T::blocks(x);
};
template <class T>
concept TupleLike = requires {
  std::tuple_size<T>::value;
};
template <class T>
concept RandomEngine = requires(T& x) {
  typename T::result_type;
  T::min();
  T::max();
  x.discard(1ULL);
};

/// What a record says of its numbers.
struct Kind {
  char letter = '{';
  std::uint8_t width = 0;
  friend bool operator==(const Kind&, const Kind&) = default;
  [[nodiscard]] bool is_integer() const { return letter == 'i' || letter == 'u'; }
  [[nodiscard]] std::string words() const {
    return letter == '{' ? "a section" : letter == 't' ? "text" : letter + std::to_string(width);
  }
};
template <class T>
[[nodiscard]] constexpr Kind kind_of() {
  if constexpr (std::is_enum_v<T>) return kind_of<std::underlying_type_t<T>>();
  else if constexpr (std::is_same_v<T, bool>) return {'b', 1};
  else if constexpr (std::is_integral_v<T>) return {std::is_signed_v<T> ? 'i' : 'u', sizeof(T)};
  else {
    constexpr int digits = std::numeric_limits<T>::digits;
    static_assert(std::is_floating_point_v<T> && digits <= 106, "phistep: numbers of this type can't be archived");
    return digits > 53 ? Kind{'w', 16} : Kind{'f', sizeof(T)};
  }
}
/// Of a number in memory, made little-endian or back.
template <class T>
void turn(T& x) {
  if constexpr (std::endian::native != std::endian::little) {
    auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(x);
    std::reverse(bytes.begin(), bytes.end());
    x = std::bit_cast<T>(bytes);
  }
}
}  // namespace detail

// What is read from a checkpoint is read into its place, and put back if anything that follows is wrong.
//
// Old values are kept, and moved back: that can't fail for want of memory, and needs no writing of what a file can't hold. What
// can't be put back (factors that are forgotten) is done at last.

/// The undoing of a Reader.
class AllOrNothing {
 public:
  /// f() when all has been read and checked: what can't be undone.
  void at_last(std::function<void()> f) {
    if (is_open_) last_.push_back(std::move(f));
    else f();
  }
  /// Notes what x was; not after pause(), within what is noted as a whole.
  template <class T>
  void keep(T& x) {
    if constexpr (!ByParts<T> && !std::is_empty_v<T>) {
      static_assert(std::is_copy_constructible_v<T> && std::is_move_assignable_v<T>,
                    "phistep: an object that can't be copied is read by its parts: `using ArchivedByParts = void;`");
      if (!keeps_) return;
      T copy = x;
      const auto old = std::make_shared<T>(std::move(x));  // it allocates before it moves
      take(x, copy);                                       // so what is put back has its old place in memory
      undo_.push_back([&x, old] { x = std::move(*old); });
    }
  }
  [[nodiscard]] auto pause() { return Paused{keeps_, std::exchange(keeps_, false)}; }

 protected:
  /// Calls read(); if it throws, what it has changed is put back.
  void attempt(auto&& read) {
    is_open_ = keeps_ = true;
    try {
      read();
      for (const auto& f : last_) f();
    } catch (...) {
      for (; !undo_.empty(); undo_.pop_back()) undo_.back()();
      throw;
    }
  }

 private:
  /// Out of line: inlined, g++ 12 holds an empty std::optional's value for uninitialized.
  template <class T>
  [[gnu::noinline]] static void take(T& to, T& from) {
    to = std::move(from);
  }
  struct Paused {
    bool& keeps;
    bool before;
    ~Paused() { keeps = before; }
  };

  std::vector<std::function<void()>> undo_, last_;
  bool is_open_ = false, keeps_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
