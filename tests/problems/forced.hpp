#pragma once

// Nonlinear, non-autonomous and (for the motion) velocity-dependent problems with a known solution: a right-hand side N
// and a solution y* are chosen first, and Ψ = N(y) + [M y*' − N(y*)](t) is what makes them meet.

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>

namespace problems {

/// M y' = Ψ(y, t) in two unknowns.
template <class T = double>
struct ForcedFlow {
  using State = Eigen::Matrix<T, 2, 1>;
  static constexpr double capacity = 1.5;

  [[nodiscard]] static State exact(T t) { return {std::cos(t), std::sin(T(1.5) * t) / 2}; }
  State operator()(const State& y, T t) const {
    const State rate{-std::sin(t), T(0.75) * std::cos(T(1.5) * t)};
    return autonomous(y) - autonomous(exact(t)) + T(capacity) * rate;
  }

 private:
  [[nodiscard]] static State autonomous(const State& y) {
    return {-2 * y[0] - y[0] * y[0] * y[0] + y[1], y[0] * y[1] - 3 * y[1]};
  }
};

/// m r'' = Ψ(r, r', t) in the plane: a hardening spring, and drag that grows with the cube of the speed.
template <class T = double>
struct ForcedMotion {
  using Vector = Eigen::Matrix<T, 2, 1>;
  using State = phistep::Motion<Vector>;
  static constexpr double mass = 1.75;

  [[nodiscard]] static State exact(T t) {
    return {Vector{std::cos(t), std::sin(T(1.5) * t) / 2}, Vector{-std::sin(t), T(0.75) * std::cos(T(1.5) * t)}};
  }
  Vector operator()(const Vector& r, const Vector& v, T t) const {
    const State y = exact(t);
    const Vector acceleration{-std::cos(t), T(-1.125) * std::sin(T(1.5) * t)};
    return autonomous(r, v) - autonomous(y.r, y.v) + T(mass) * acceleration;
  }

 private:
  [[nodiscard]] static Vector autonomous(const Vector& r, const Vector& v) {
    return -(4 + r.squaredNorm()) * r - (T(0.5) + v.squaredNorm()) * v;
  }
};

/// r'' = −4r − |r|² r in the plane: nonlinear, and a force that ignores v.
struct HardeningSpring {
  using Vector = Eigen::Vector2d;
  using State = phistep::Motion<Vector>;

  [[nodiscard]] static State start() { return {Vector{1, 0.2}, Vector{0, 0.8}}; }
  Vector operator()(const Vector& r) const { return -(4 + r.squaredNorm()) * r; }
  [[nodiscard]] Eigen::Matrix2d jacobian(const Vector& r) const {
    return -(4 + r.squaredNorm()) * Eigen::Matrix2d::Identity() - 2 * r * r.transpose();
  }
};

}  // namespace problems
