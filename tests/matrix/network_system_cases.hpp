#pragma once

// What network_system.test.cpp and its full half share.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "support/catch.hpp"

namespace network_cases {

using namespace phistep;
using Vec = Eigen::VectorXd;

/// A random net: `particles` in a box, each joined to a few others; the last one to none.
template <int dim>
struct Net {
  Motion<Vec> state;
  std::vector<Spring> springs;
  Vec masses;

  explicit Net(int particles, double longest = 0.8, unsigned seed = 5) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto numbers = [&](double from, double to) {
      return Vec::NullaryExpr(dim * particles, [&](Eigen::Index) { return from + (to - from) * uniform(random); })
          .eval();
    };
    state.r = numbers(0, 3);
    state.v = numbers(-1, 1);
    masses = numbers(0.5, 2);
    for (int i = 0; i + 1 < particles; ++i)
      for (int n = 0; n < 4; ++n) {
        const int j = static_cast<int>(uniform(random) * (particles - 1));
        if (i == j) continue;
        const double l = (state.r.template segment<dim>(dim * i) - state.r.template segment<dim>(dim * j)).norm();
        springs.push_back({i, j, 10 + 50 * uniform(random), longest * l * uniform(random)});
      }
  }
  [[nodiscard]] auto each_mass() const {
    return [this](auto&& put) {
      for (Eigen::Index i = 0; i < masses.size(); ++i) put(i, i, masses[i]);
    };
  }
};

template <class V>
struct View {
  const V &r, &v;
};

/// W by the dense system's entries, for solves that must be clamped.
template <int dim>
Eigen::MatrixXd clamped_matrix(const Net<dim>& net, const std::vector<Spring>& springs, double gamma) {
  Eigen::MatrixXd W = net.masses.asDiagonal();
  using Small = Eigen::Matrix<double, dim, dim>;
  for (const Spring& s : springs) {
    const auto i = dim * s.i, j = dim * s.j;
    const Eigen::Matrix<double, dim, 1> d = net.state.r.template segment<dim>(j) - net.state.r.template segment<dim>(i);
    const double length = d.norm();
    const Small along = d * d.transpose() / (length * length);
    const Small B = gamma * s.stiffness * (along + std::max(0.0, 1 - s.length / length) * (Small::Identity() - along));
    W.template block<dim, dim>(i, i) += B;
    W.template block<dim, dim>(j, j) += B;
    W.template block<dim, dim>(i, j) -= B;
    W.template block<dim, dim>(j, i) -= B;
  }
  return W;
}

}  // namespace network_cases
