#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

namespace problems {

/// Seven argon atoms of a frozen crystal in the plane (Hairer, Lubich & Wanner, Geometric Numerical Integration, I.4).
/// In nm, ns, kg and J, which fit together: 1 nm/ns is 1 m/s, and 1 J/nm over 1 kg is 1 nm/ns².
struct Argon {
  using Vector = Eigen::Matrix<double, 2, 7>;  // one column an atom
  using State = phistep::Motion<Vector>;
  static constexpr double boltzmann = 1.380658e-23;   // [J/K]
  static constexpr double mass = 66.34e-27;           // [kg]
  static constexpr double depth = 119.8 * boltzmann;  // ε [J]
  static constexpr double sigma = 0.341;              // [nm]

  [[nodiscard]] static State start() {
    return {Vector{{0, 0.02, 0.34, 0.36, -0.02, -0.35, -0.31}, {0, 0.39, 0.17, -0.21, -0.40, -0.16, 0.21}},
            Vector{{-30, 50, -70, 90, 80, -40, -80}, {-20, -90, -60, 40, 90, 100, -60}}};
  }
  /// Lennard-Jones, all pairs. [J/nm]
  Vector operator()(const Vector& r) const {
    Vector force = Vector::Zero();
    for (int i = 0; i < 7; ++i)
      for (int j = i + 1; j < 7; ++j) {
        const Eigen::Vector2d d = r.col(j) - r.col(i);
        const double s = attraction(d);
        const Eigen::Vector2d pull = 24 * depth * (s - 2 * s * s) / d.squaredNorm() * d;
        force.col(i) += pull;
        force.col(j) -= pull;
      }
    return force;
  }
  /// H/k_B. [K]
  [[nodiscard]] static double energy(const State& y) {
    double potential = 0;
    for (int i = 0; i < 7; ++i)
      for (int j = i + 1; j < 7; ++j) {
        const double s = attraction(y.r.col(j) - y.r.col(i));
        potential += 4 * depth * (s * s - s);
      }
    return (mass / 2 * y.v.squaredNorm() + potential) / boltzmann;
  }

 private:
  [[nodiscard]] static double attraction(const Eigen::Vector2d& d) {
    const double s = sigma * sigma / d.squaredNorm();
    return s * s * s;
  }
};

}  // namespace problems
