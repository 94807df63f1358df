#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>

namespace problems {

/// Arenstorf's orbit of a satellite around earth and moon, in the frame that turns with them (Hairer, Norsett & Wanner,
/// Solving ODEs I, sect. II.0): after one period it is back at its start. A relative error made there grows by 1e4.
struct Arenstorf {
  using Vector = Eigen::Vector2d;
  using State = phistep::Motion<Vector>;
  static constexpr double moon = 0.012277471, end = 17.0652165601579625588917206249;

  [[nodiscard]] static State start() { return {Vector{0.994, 0}, Vector{0, -2.00158510637908252240537862224}}; }
  Vector operator()(const Vector& r, const Vector& v) const {
    const Vector earth = r + Vector{moon, 0}, from_moon = r - Vector{1 - moon, 0};
    const Vector coriolis{2 * v[1], -2 * v[0]};
    return r + coriolis - (1 - moon) / cube(earth.norm()) * earth - moon / cube(from_moon.norm()) * from_moon;
  }
  [[nodiscard]] static State exact() { return start(); }

 private:
  [[nodiscard]] static double cube(double x) { return x * x * x; }
};

}  // namespace problems
