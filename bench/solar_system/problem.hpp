#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cstddef>

#include "problems/outer_solar_system.hpp"

/// The outer solar system at rest as a whole. In the frame in which its data are published, where the Sun starts at rest, it
/// would be 250 astronomical units from the origin after 10⁵ years, and lose a digit and a half.
struct Planets : problems::OuterSolarSystem {
  using State = phistep::Motion<Vector>;

  [[nodiscard]] static State start() {
    State y{positions(), velocities()};
    double mass = 0;
    for (const double m : masses) mass += m;
    for (auto* block : {&y.r, &y.v})
      for (int axis = 0; axis < 3; ++axis) {
        auto x = block->segment<6>(6 * axis);
        double centre = 0;
        for (int i = 0; i < 6; ++i) centre += masses[static_cast<std::size_t>(i)] * x[i] / mass;
        x.array() -= centre;
      }
    return y;
  }
  /// Kinetic and potential energy, with more digits than the state has.
  [[nodiscard]] static long double energy(const State& y) {
    const auto of = [](const Vector& x, int i) { return Eigen::Matrix<long double, 3, 1>{x[i], x[6 + i], x[12 + i]}; };
    long double sum = 0;
    for (int i = 0; i < 6; ++i) {
      const long double m = masses[static_cast<std::size_t>(i)];
      sum += m * of(y.v, i).squaredNorm() / 2;
      for (int j = 0; j < i; ++j) sum -= G * m * masses[static_cast<std::size_t>(j)] / (of(y.r, i) - of(y.r, j)).norm();
    }
    return sum;
  }
};
