/// @file
/// What can be archived, and what its records say of it.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
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
}  // namespace detail

}}  // namespace phistep::PHISTEP_ABI
