#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <array>
#include <cmath>

/// The Sun, Jupiter, Saturn, Uranus, Neptune and Pluto: E. Hairer, C. Lubich & G. Wanner, Geometric Numerical Integration,
/// I.2.4. Lengths in astronomical units, times in days, masses in that of the Sun. At rest as a whole: in the book's frame,
/// where the Sun starts at rest, they would be 250 units from the origin after 10⁵ years, and lose a digit and a half.
struct OuterSolarSystem {
  using Bodies = Eigen::Matrix<double, 18, 1>;  // x, y, z of each body
  using State = phistep::Motion<Bodies>;
  static constexpr int bodies = 6;
  static constexpr double G = 2.95912208286e-4;
  static constexpr std::array<double, bodies> masses{1.00000597682,      0.000954786104043,  0.000285583733151,
                                                     0.0000437273164546, 0.0000517759138449, 1.0 / 1.3e8};

  [[nodiscard]] static State start() {
    State y;
    y.r << 0, 0, 0, -3.5023653, -3.8169847, -1.5507963, 9.0755314, -3.0458353, -1.6483708, 8.3101420, -16.2901086,
        -7.2521278, 11.4707666, -25.7294829, -10.8169456, -15.5387357, -25.2225594, -3.1902382;
    y.v << 0, 0, 0, 0.00565429, -0.00412490, -0.00190589, 0.00168318, 0.00483525, 0.00192462, 0.00354178, 0.00137102,
        0.00055029, 0.00288930, 0.00114527, 0.00039677, 0.00276725, -0.00170702, -0.00136504;
    for (auto* block : {&y.r, &y.v}) {
      Eigen::Vector3d centre = Eigen::Vector3d::Zero();
      double mass = 0;
      for (int i = 0; i < bodies; ++i) {
        centre += masses[static_cast<std::size_t>(i)] * block->segment<3>(3 * i);
        mass += masses[static_cast<std::size_t>(i)];
      }
      for (int i = 0; i < bodies; ++i) block->segment<3>(3 * i) -= centre / mass;
    }
    return y;
  }
  /// Accelerations, each pair once, as anybody would write them.
  Bodies operator()(const Bodies& r) const {
    Bodies a = Bodies::Zero();
    for (int i = 0; i < bodies; ++i)
      for (int j = i + 1; j < bodies; ++j) {
        const double x = r[3 * j] - r[3 * i], y = r[3 * j + 1] - r[3 * i + 1], z = r[3 * j + 2] - r[3 * i + 2];
        const double d2 = x * x + y * y + z * z, w = G / (d2 * std::sqrt(d2));
        const double wi = w * masses[static_cast<std::size_t>(j)], wj = w * masses[static_cast<std::size_t>(i)];
        a[3 * i] += wi * x, a[3 * i + 1] += wi * y, a[3 * i + 2] += wi * z;
        a[3 * j] -= wj * x, a[3 * j + 1] -= wj * y, a[3 * j + 2] -= wj * z;
      }
    return a;
  }
  /// Kinetic and potential energy, with more digits than the state has.
  [[nodiscard]] static long double energy(const State& y) {
    long double sum = 0;
    for (int i = 0; i < bodies; ++i) {
      const long double mi = masses[static_cast<std::size_t>(i)];
      sum += mi * y.v.segment<3>(3 * i).cast<long double>().squaredNorm() / 2;
      for (int j = 0; j < i; ++j)
        sum -= G * mi * masses[static_cast<std::size_t>(j)] /
               (y.r.segment<3>(3 * i).cast<long double>() - y.r.segment<3>(3 * j).cast<long double>()).norm();
    }
    return sum;
  }
};
