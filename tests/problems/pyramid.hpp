#pragma once

#include <Eigen/Core>
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace problems {

/// Grains of mass 1 and radius ½ in a pyramid of square layers that touch, on a floor, level or tilted. Friction alone keeps it
/// together: grains that slip or roll let the lowest layer be pushed apart.
struct Pyramid {
  using State = phistep::Particles<double, 3, phistep::Spin>;
  static constexpr double radius = 0.5, mass = 1, gravity = 1, stiffness = 1e5;
  int side = 4;     ///< of the lowest layer
  double tilt = 0;  ///< [rad]
  phistep::Hooke law{.stiffness = stiffness, .restitution = 0.2, .friction = 0.8, .rolling_friction = 0.1};

  [[nodiscard]] State start() const {
    int count = 0;
    for (int n = side; n > 0; --n) count += n * n;
    Eigen::Matrix3Xd r(3, count);
    int i = 0;
    for (int n = side, layer = 0; n > 0; --n, ++layer)
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b)
          r.col(i++) << a - (n - 1) / 2.0, b - (n - 1) / 2.0, radius + layer * std::numbers::sqrt2 / 2;
    State y{r};
    y.set_mass(mass).set_radius(radius);
    return y;
  }
  [[nodiscard]] auto force() const {
    return phistep::Gravity{Eigen::Vector3d{gravity * std::sin(tilt), 0, -gravity * std::cos(tilt)}} +
           phistep::Contact{law} + phistep::Walls{law, phistep::Plane<3>{{0, 0, 0}, {0, 0, 1}}};
  }
  /// A fortieth of a contact between two grains.
  [[nodiscard]] static double dt() { return std::numbers::pi * std::sqrt(mass / 2 / stiffness) / 40; }

  [[nodiscard]] static double height(const State& y) { return y.r.row(2).mean(); }
  [[nodiscard]] static double kinetic_energy(const State& y) {
    return mass / 2 * y.v.squaredNorm() + 0.2 * mass * radius * radius * y.omega.squaredNorm();
  }
  [[nodiscard]] static double deepest(const State& y) {
    double overlap = radius - y.r.row(2).minCoeff();
    for (Eigen::Index i = 0; i < y.size(); ++i)
      for (Eigen::Index j = 0; j < i; ++j) overlap = std::max(overlap, 2 * radius - (y.r.col(i) - y.r.col(j)).norm());
    return overlap;
  }
};

}  // namespace problems
