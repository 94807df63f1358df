#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>

#include "problems/march.hpp"

namespace problems {

/// m r'' = N(r) + [m r*'' − N(r*)](t) in the plane: nonlinear, driven, a force that ignores v; r* solves it.
template <class T = double>
struct DrivenMotion : phistep::ForceTerm {
  using Vector = Eigen::Matrix<T, 2, 1>;
  using State = phistep::Motion<Vector>;
  static constexpr bool uses_velocity = false, uses_time = true;
  static constexpr double mass = 1.75;

  [[nodiscard]] static State exact(T t) {
    return {Vector{std::cos(t), std::sin(T(1.5) * t) / 2}, Vector{-std::sin(t), T(0.75) * std::cos(T(1.5) * t)}};
  }
  void add(T t, const auto& y, auto& out) const {
    const Vector acceleration{-std::cos(t), T(-1.125) * std::sin(T(1.5) * t)};
    out.force += pull(y.r) - pull(exact(t).r) + T(mass) * acceleration;
  }

 private:
  [[nodiscard]] static Vector pull(const Vector& r) {
    return Vector{-4 * r[0] - r[0] * r.squaredNorm() + r[1], -3 * r[1] + r[0] * r[1]};
  }
};

/// After n equal steps from t = 0 to 3.
template <class T, class Scheme>
[[nodiscard]] double error_at_end(Scheme scheme, int steps) {
  using Problem = DrivenMotion<T>;
  const auto y = Problem::exact(0);
  phistep::PhiStepper stepper{y, Problem{}, scheme, phistep::mass(T(Problem::mass))};
  return distance(march(stepper, y, T(0), T(3), steps), Problem::exact(3));
}

}  // namespace problems
