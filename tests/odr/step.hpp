#pragma once

#include <phistep/all.hpp>

// The same templates, instantiated in every unit that calls this.
inline double step_once(double dt) {
  auto spring = [](const Eigen::Vector2d& r, const Eigen::Vector2d& v) -> Eigen::Vector2d {
    return -4.0 * r - 0.1 * v;
  };
  phistep::Motion state{Eigen::Vector2d{1, 0}, Eigen::Vector2d{0, 1}};
  phistep::PhiStepper stepper{state, spring, phistep::trapezoidal, phistep::mass(2.0)};
  return stepper.step(state, 0.0, dt) ? state.r.x() : -1.0;
}
