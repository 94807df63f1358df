// What spring_rows.test.cpp and spring_rows.full.cpp share.
#pragma once

#include <phistep/base/state/motion.hpp>
#include <phistep/particles/springs/spring_rows.hpp>
#include <phistep/particles/springs/springs.hpp>

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "support/catch.hpp"

#ifdef _OPENMP
#include <omp.h>
#endif

using namespace phistep;

namespace spring_rows_cases {

enum class Mesh { grid, diagonals, anyhow };

/// A sheet of side × side particles; with diagonals this way or that, rows differ in length; or springs between anybody.
inline std::vector<Spring> springs_of(Mesh mesh, int side) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> about(0.5, 1.5);
  std::vector<Spring> springs;
  const int n = side * side;
  if (mesh == Mesh::anyhow) {
    for (int s = 0; s < 3 * n; ++s) {
      const auto i = static_cast<int>(random() % static_cast<unsigned>(n));
      const auto j = static_cast<int>(random() % static_cast<unsigned>(n));
      if (i != j) springs.push_back({i, j, about(random), about(random)});
    }
    return springs;
  }
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const int i = y * side + x;
      if (x + 1 < side) springs.push_back({i, i + 1, 3, 1});
      if (y + 1 < side) springs.push_back({i + side, i, 4, 1});
      if (mesh == Mesh::diagonals && x + 1 < side && y + 1 < side) {
        if (random() % 2) springs.push_back({i, i + side + 1, 2, about(random)});
        else springs.push_back({i + 1, i + side, 2, about(random)});
      }
    }
  return springs;
}

/// The same springs in another order, between particles of which each has another number, below `particles`.
inline std::vector<Spring> renumbered(std::vector<Spring> springs, int particles) {
  std::shuffle(springs.begin(), springs.end(), std::mt19937(1));
  std::vector<std::ptrdiff_t> name(static_cast<std::size_t>(particles));
  std::iota(name.begin(), name.end(), 0);
  std::shuffle(name.begin(), name.end(), std::mt19937(2));
  for (Spring& s : springs) s.i = name[static_cast<std::size_t>(s.i)], s.j = name[static_cast<std::size_t>(s.j)];
  return springs;
}

template <class Scalar, int dim>
struct Points {
  using Vectors = Eigen::Matrix<Scalar, dim, Eigen::Dynamic>;
  Vectors r, v;
  explicit Points(Eigen::Index n) : r(dim, n), v(dim, n) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (Eigen::Index k = 0; k < r.size(); ++k) {
      r.data()[k] = static_cast<Scalar>(uniform(random));
      v.data()[k] = static_cast<Scalar>(uniform(random));
    }
  }
};

inline constexpr double damping = 0.75;

template <class Scalar, int dim, bool damped>
typename Points<Scalar, dim>::Vectors forces(const std::vector<Spring>& springs, const Points<Scalar, dim>& y,
                                             const std::uint8_t* still = nullptr) {
  SpringRows<Scalar, dim, damped> rows;
  rows.build(springs, y.r.cols());
  typename Points<Scalar, dim>::Vectors f = Points<Scalar, dim>::Vectors::Zero(dim, y.r.cols());
  rows.add(y.r.data(), y.v.data(), still, static_cast<Scalar>(damping), f.data());
  return f;
}

/// Largest error in units of its bound. To each spring's pull, rounding adds at most 12 ε (k (ℓ + L) + c|Δv|): its
/// dozen operations work on terms of no more than that; to a sum of n pulls n ε times as much.
template <class Scalar, int dim, bool damped>
double error(const std::vector<Spring>& springs, const Points<Scalar, dim>& y,
             const typename Points<Scalar, dim>::Vectors& f) {
  const Eigen::Matrix<double, dim, Eigen::Dynamic> r = y.r.template cast<double>(), v = y.v.template cast<double>();
  Eigen::Matrix<double, dim, Eigen::Dynamic> right = 0 * r;
  Eigen::VectorXd terms = Eigen::VectorXd::Zero(r.cols()), count = terms;
  for (const Spring& s : springs) {
    const Eigen::Matrix<double, dim, 1> d = r.col(s.j) - r.col(s.i), u = v.col(s.j) - v.col(s.i);
    const double length = d.norm();
    for (const auto end : {s.i, s.j}) {
      terms[end] += s.stiffness * (length + s.length) + damping * u.norm();
      count[end] += 1;
    }
    if (length == 0) continue;
    const double pull = s.stiffness * (length - s.length) + (damped ? damping * d.dot(u) / length : 0);
    right.col(s.i) += pull / length * d;
    right.col(s.j) -= pull / length * d;
  }
  const double epsilon = std::numeric_limits<Scalar>::epsilon();
  double worst = 0;
  for (Eigen::Index i = 0; i < r.cols(); ++i) {
    const double off = (f.col(i).template cast<double>() - right.col(i)).norm();
    if (!(off == 0)) worst = std::max(worst, off / (epsilon * (12 + count[i]) * terms[i]));
  }
  return worst;
}

template <class Scalar, int dim>
void check_rows() {
  for (const Mesh mesh : {Mesh::grid, Mesh::diagonals, Mesh::anyhow})
    for (const int side : {2, 5, 23}) {
      auto springs = springs_of(mesh, side);
      Points<Scalar, dim> y(side * side + 3);  // three without springs
      y.r.col(springs[1].i) = y.r.col(springs[1].j), springs[1].length = 0;
      CHECK(error<Scalar, dim, false>(springs, y, forces<Scalar, dim, false>(springs, y)) <= 1);
      CHECK(error<Scalar, dim, true>(springs, y, forces<Scalar, dim, true>(springs, y)) <= 1);
      springs = renumbered(springs, side * side);
      CHECK(error<Scalar, dim, true>(springs, y, forces<Scalar, dim, true>(springs, y)) <= 1);
    }
}

}  // namespace spring_rows_cases
