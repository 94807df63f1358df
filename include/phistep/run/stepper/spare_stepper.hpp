/// @file
/// A copy of a run's stepper, to step beside the run. It is made once, and from then on assigned to: that allocates nothing
/// where sizes stay (and the force can be assigned, base/machine/assignable.hpp).
#pragma once

#include <optional>
#include <type_traits>

#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Stepper>
class SpareStepper {
 public:
  void copy(const Stepper& stepper) {
    if constexpr (std::is_copy_assignable_v<Stepper>) stepper_ = stepper;
    else stepper_.emplace(stepper);
    before_ = stepper_->statistics();
  }
  [[nodiscard]] Stepper* operator->() { return &*stepper_; }
  [[nodiscard]] Stepper& operator*() { return *stepper_; }
  /// What it has cost since it is a copy.
  [[nodiscard]] Statistics spent() const { return stepper_->statistics() - before_; }

 private:
  std::optional<Stepper> stepper_;
  Statistics before_;
};

}}  // namespace phistep::PHISTEP_ABI
