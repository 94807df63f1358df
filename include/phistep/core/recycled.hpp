/// @file
/// Shared objects whose memory serves again.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Hands out objects without another owner, as they were left, or new ones.
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
  /// What has no other owner is given back, the rest is when its owners are gone.
  void forget() {
    kept_.clear();
    next_ = 0;
  }

 private:
  std::vector<std::shared_ptr<T>> kept_;
  std::size_t next_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
