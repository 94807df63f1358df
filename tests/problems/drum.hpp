#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>
#include <vector>

namespace problems {

/// A net of 20 × 20 unit masses one apart, with springs along its lines and a viscous dashpot beside each, stretched by 1 %
/// in a rim that does not move (masses of 1e20), bulged out and let go. It falls back within a second; stretching motions
/// die out at rates up to 1.6e5, so that an explicit scheme would need some 40,000 steps.
struct Drum {
  using State = phistep::Motion<Eigen::VectorXd>;
  static constexpr int side = 22, particles = side * side;
  static constexpr double stiffness = 1e6, length = 0.99, damping = 2e4, bulge = 0.5, end = 0.5;

  [[nodiscard]] static bool is_rim(int x, int y) { return x == 0 || y == 0 || x == side - 1 || y == side - 1; }
  [[nodiscard]] static auto force() {
    std::vector<phistep::Spring> springs;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const int i = x + side * y;
        if (x + 1 < side && !(is_rim(x, y) && is_rim(x + 1, y))) springs.push_back({i, i + 1, stiffness, length});
        if (y + 1 < side && !(is_rim(x, y) && is_rim(x, y + 1))) springs.push_back({i, i + side, stiffness, length});
      }
    return phistep::spring_network<3>(springs, phistep::SpringDamping{damping});
  }
  /// One mass a component.
  [[nodiscard]] static Eigen::VectorXd masses() {
    Eigen::VectorXd m = Eigen::VectorXd::Ones(3 * particles);
    for (int i = 0; i < particles; ++i)
      if (is_rim(i % side, i / side)) m.segment<3>(3 * i).setConstant(1e20);
    return m;
  }
  [[nodiscard]] static State start() {
    State y{Eigen::VectorXd::Zero(3 * particles), Eigen::VectorXd::Zero(3 * particles)};
    constexpr double pi = 3.14159265358979323846;
    for (int i = 0; i < particles; ++i) {
      const int x = i % side, z = i / side;
      const double height = bulge * std::sin(pi * x / (side - 1)) * std::sin(pi * z / (side - 1));
      y.r.segment<3>(3 * i) = Eigen::Vector3d{1.0 * x, 1.0 * z, is_rim(x, z) ? 0 : height};
    }
    return y;
  }

  /// Positions, then velocities of particles near a corner, near a side and near the middle.
  [[nodiscard]] static std::vector<Eigen::Index> samples() {
    std::vector<Eigen::Index> indices;
    for (const Eigen::Index block : {0, 3 * particles})
      for (const Eigen::Index i : {2 + 3 * side, 7 + side, 10 + 10 * side, 15 + 8 * side})
        for (const Eigen::Index axis : {0, 1, 2}) indices.push_back(block + 3 * i + axis);
    return indices;
  }
  /// Of the samples at the end, by the extrapolated midpoint rule of order 12 in extended precision.
  [[nodiscard]] static Eigen::VectorXd exact() {
    return Eigen::VectorXd{{
        1.99999906495992573e+00, 2.99999743671488662e+00, -4.67937129342799834e-03, 6.99999680061291172e+00, 1.00000164694041158e+00, -4.88286139710713604e-03, 1.00000009850809602e+01, 1.00000009850809601e+01, -3.86316299547440119e-02, 1.49999942678261386e+01, 8.00000189903168062e+00, -2.80183374782763912e-02, 1.48525841617068080e-03, 1.05508404589746509e-03, 1.23727665049361715e+00, 4.54262750928932060e-04, 3.05663079678294218e-03, 1.25143655654485511e+00, 2.12164269112933782e-03, 2.12164269113150595e-03, 9.63409390474257944e+00, -1.19590383760088762e-02, 5.91956034214322614e-03, 7.05485885577352808e+00}};
  }
};

}  // namespace problems
