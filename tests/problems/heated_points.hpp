#pragma once

#include <Eigen/Core>

#include <cmath>

namespace problems {

/// The assignment of the φ-method's source: ρC θ' = −B cos(2t) x + ρ a I at points x, I = (1, …, 1). The right-hand
/// side ignores θ, so that every scheme is a quadrature here. Closed form: θ₀ − B sin(2t) x/(2ρC) + (a/C) t I.
struct HeatedPoints {
  using State = Eigen::Vector3d;
  static constexpr double rho = 2.5, C = 0.8, B = 3, a = 0.7;

  [[nodiscard]] static State points() { return {0.5, 1, 2}; }
  [[nodiscard]] static State start() { return {300, 310, 290}; }
  State operator()(const State& /*theta*/, double t) const {
    return -B * std::cos(2 * t) * points() + State::Constant(rho * a);
  }
  [[nodiscard]] static State exact(double t) {
    return start() - B * std::sin(2 * t) / (2 * rho * C) * points() + State::Constant(a / C * t);
  }
};

}  // namespace problems
