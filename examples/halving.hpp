// A stepper of one's own around another: where a step fails, two of half the length. `integrate` takes it like any other.
#pragma once

#include <phistep/core/statistics.hpp>
#include <phistep/core/step_report.hpp>

template <class Stepper>
class Halving {
 public:
  /// @param shortest  a step that fails is halved down to this length, then its failure is reported [time]
  Halving(Stepper& stepper, double shortest) : stepper_{&stepper}, shortest_{shortest} {}

  phistep::StepReport step(auto& state, double t, double dt) {
    phistep::StepReport report = stepper_->step(state, t, dt);  // a failed step leaves the state as it was
    if (report || dt < 2 * shortest_) return report;
    ++halved_;
    report = step(state, t, dt / 2);
    return report ? step(state, t + dt / 2, dt / 2) : report;
  }
  [[nodiscard]] const phistep::Statistics& statistics() const { return stepper_->statistics(); }
  [[nodiscard]] int halved() const { return halved_; }

 private:
  Stepper* stepper_;
  double shortest_;
  int halved_ = 0;
};
