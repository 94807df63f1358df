/// @file
/// One linearized step of backward Euler for a cloth, from Baraff & Witkin (Large steps in cloth simulation, 1998):
///
///     (M + Δt² K) Δv = Δt (f − Δt K v),    M = 1, Δt = 1, so that the stiffness k is Δt²k/m
///
/// A square of G × G particles that stand 5 % off their places, with structural, shear and bending springs;
/// K = k nnᵀ + k max(0, 1 − L/ℓ) (I − nnᵀ) for each spring, hence definite.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace cloth {

struct Spring {
  int i, j;
  double length;
};

struct Problem {
  double k;
  std::vector<Eigen::Vector3d> r, v;
  std::vector<Spring> springs;
  Eigen::VectorXd right_hand_side;

  [[nodiscard]] Eigen::Index unknowns() const { return right_hand_side.size(); }

  /// n and the clamped 1 − L/ℓ of a spring
  [[nodiscard]] Eigen::Vector3d direction(const Spring& s, double& across) const {
    const Eigen::Vector3d d = r[static_cast<std::size_t>(s.j)] - r[static_cast<std::size_t>(s.i)];
    const double length = d.norm();
    across = std::max(0.0, 1 - s.length / length);
    return d / length;
  }
  /// y = (M + Δt² K) x
  [[nodiscard]] Eigen::VectorXd product(const Eigen::VectorXd& x) const {
    Eigen::VectorXd y = x;
    for (const Spring& s : springs) {
      double across = 0;
      const Eigen::Vector3d n = direction(s, across), d = x.segment<3>(3 * s.i) - x.segment<3>(3 * s.j);
      const Eigen::Vector3d q = k * (across * d + (1 - across) * n.dot(d) * n);
      y.segment<3>(3 * s.i) += q;
      y.segment<3>(3 * s.j) -= q;
    }
    return y;
  }

  Problem(int G, double stiffness) : k{stiffness} {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    const auto shake = [&] {
      const double x = normal(random), y = normal(random), z = normal(random);
      return Eigen::Vector3d{x, y, z};
    };
    for (int y = 0; y < G; ++y)
      for (int x = 0; x < G; ++x) {
        r.push_back(Eigen::Vector3d(x, y, 0) + 0.05 * shake());
        v.push_back(0.1 * shake());
      }
    for (int y = 0; y < G; ++y)
      for (int x = 0; x < G; ++x) {
        const int i = y * G + x;
        if (x + 1 < G) springs.push_back({i, i + 1, 1});
        if (y + 1 < G) springs.push_back({i, i + G, 1});
        if (x + 1 < G && y + 1 < G) {
          springs.push_back({i, i + G + 1, std::sqrt(2.0)});
          springs.push_back({i + 1, i + G, std::sqrt(2.0)});
        }
        if (x + 2 < G) springs.push_back({i, i + 2, 2});
        if (y + 2 < G) springs.push_back({i, i + 2 * G, 2});
      }
    Eigen::VectorXd& b = right_hand_side;
    b.setZero(3 * static_cast<Eigen::Index>(r.size()));
    for (const Spring& s : springs) {
      const auto i = static_cast<std::size_t>(s.i), j = static_cast<std::size_t>(s.j);
      double across = 0;
      const Eigen::Vector3d d = r[j] - r[i], n = direction(s, across), dv = v[j] - v[i];
      const Eigen::Vector3d f = k * (1 - s.length / d.norm()) * d + k * (across * dv + (1 - across) * n.dot(dv) * n);
      b.segment<3>(3 * s.i) += f;
      b.segment<3>(3 * s.j) -= f;
    }
    for (Eigen::Index i = 2; i < b.size(); i += 3) b[i] -= 9.81e-3;
  }
};

constexpr double tolerance = 1e-6;  ///< relative residual

/// What a rival found, how many iterations it took (0: direct).
struct Answer {
  Eigen::VectorXd x;
  long iterations = 0;
};

}  // namespace cloth
