#pragma once

// Twenty steps of a state of any shape.

#include <phistep/phistep.hpp>

#include "contract/states.hpp"
#include "support/catch.hpp"

namespace states {

inline void check_step(const phistep::StepReport& step) {
  INFO(step.message());
  REQUIRE(step);
}

template <class Case>
Eigen::VectorXd run(const auto& force, auto scheme) {
  Case c;
  phistep::PhiStepper stepper{c.state, force, scheme};
  for (int n = 0; n < 20; ++n) check_step(stepper.step(c.state, 0.1 * n, 0.1));
  return numbers(c.state);
}

// Explicit schemes must agree to the bit; implicit ones up to rounding (the order of the unknowns may differ).
inline void check_same(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double tolerance) {
  CHECK(distance(a, b) <= tolerance);
}
template <class V>
void check_first_order(auto scheme, double tolerance) {
  check_same(run<FirstOrder<V>>(DrivenPull{}, scheme), run<FirstOrder<Dynamic>>(DrivenPull{}, scheme), tolerance);
}
template <class V>
void check_motion(const auto& force, auto scheme, double tolerance) {
  check_same(run<SecondOrder<V>>(force, scheme), run<SecondOrder<Dynamic>>(force, scheme), tolerance);
}

}  // namespace states
