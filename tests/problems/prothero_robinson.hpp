#pragma once

#include <Eigen/Core>

#include <cmath>

namespace problems {

/// y' = λ (y − cos t) − sin t from y(0) = 1: the solution cos t is smooth, the way back to it is stiff.
struct ProtheroRobinson {
  using State = Eigen::Matrix<double, 1, 1>;
  double lambda = -1e6;

  [[nodiscard]] static State exact(double t) { return State{std::cos(t)}; }
  State operator()(const State& y, double t) const { return State{lambda * (y[0] - std::cos(t)) - std::sin(t)}; }
  State jacobian(const State& /*y*/, double /*t*/) const { return State{lambda}; }
};

}  // namespace problems
