/// @file
/// Workspaces: memory that serves again from call to call.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

/// Frees v's memory.
template <class V>
void release(V& v) {
  V{}.swap(v);
}

/// Shared objects whose memory serves again: hands out those without another owner, as they were left, or new ones.
/// @tparam most  kept: the committed one, the trial's, the one before, one for a checkpoint
template <class T, std::size_t most = 4>
class Recycled {
 public:
  Recycled() = default;
  Recycled(const Recycled&) {}  // a copy starts with none
  Recycled(Recycled&&) noexcept = default;
  Recycled& operator=(const Recycled&) { return *this; }
  Recycled& operator=(Recycled&&) noexcept = default;
  ~Recycled() = default;

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
  std::vector<std::shared_ptr<T>> kept_;
  std::size_t next_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
