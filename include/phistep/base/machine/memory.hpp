/// @file
/// Storage, not a force's memory: members that a class has under a condition only (Only), workspaces that serve again, ends of scopes
/// (AtExit), serial numbers of objects.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Stands in for an absent member: takes any arguments of its constructor, and no space under [[no_unique_address]]. Two in
/// one object need different types for that: T and n tell them apart.
template <class T = void, int n = 0>
struct Absent {
  constexpr Absent() = default;
  constexpr explicit Absent(const auto&... /*any*/) {}
};

/// The type of a member: T if the condition holds.
///
///     [[no_unique_address]] Only<has_time, Rate> psi_t_;
template <bool condition, class T, int n = 0>
using Only = std::conditional_t<condition, T, Absent<T, n>>;

/// A T that is not copied along with its owner: the copy makes its own. Moving takes it along. What it holds from call to call
/// saves work.
template <class T>
struct Scratch : T {
  Scratch() = default;
  Scratch(const Scratch&) : T{} {}
  Scratch(Scratch&&) noexcept = default;
  Scratch& operator=(const Scratch& other) {
    if (this != &other) static_cast<T&>(*this) = T{};
    return *this;
  }
  Scratch& operator=(Scratch&&) noexcept = default;
  ~Scratch() = default;
};

/// v.resize(n), with 1/32 to spare where v needs other memory: by itself a vector takes twice as much as it had.
void resize_with_spare(auto& v, std::size_t n) {
  if (v.capacity() < n) v.reserve(n + n / 32);
  v.resize(n);
}

template <class V>
void release(V& v) {
  V{}.swap(v);
}

/// Shared objects whose memory serves again: hands out those without another owner, as they were left, or new ones.
/// @tparam most  kept: the committed one, the trial's, the one before, one for a checkpoint
template <class T, std::size_t most = 4>
class Recycled {
 public:
  [[nodiscard]] std::shared_ptr<T> take() {
    for (auto& one : kept_)
      if (one.use_count() == 1) return one;
    auto made = std::make_shared<T>();
    if (kept_.size() < most) kept_.push_back(made);
    else kept_[next_++ % kept_.size()] = made;
    return made;
  }
  /// Releases the objects; one with another owner is freed when that owner is gone.
  void forget() {
    kept_.clear();
    next_ = 0;
  }

 private:
  Scratch<std::vector<std::shared_ptr<T>>> kept_;
  std::size_t next_ = 0;
};

/// Calls f at the end of its scope, by an exception as well.
template <class F>
struct AtExit {
  F f;
  ~AtExit() { f(); }
};
template <class F>
AtExit(F) -> AtExit<F>;

/// A number that nothing else has had, whatever the thread: what was made for one object is known by it not to belong to another.
[[nodiscard]] inline std::uint64_t next_serial() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}}  // namespace phistep::PHISTEP_ABI
