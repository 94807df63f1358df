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

/// B = along nnᵀ + across (I − nnᵀ) with along < across, as pair forces have near the bottom of their potential.
struct Softening {
  const Net<3>& net;
  void operator()(const auto& y, auto& sink) const {
    for (const Spring& s : net.springs) {
      const Eigen::Vector3d n = (y.r.template segment<3>(3 * s.j) - y.r.template segment<3>(3 * s.i)).normalized();
      const double along = 0.1 * s.stiffness, across = 0.3 * s.stiffness;
      if constexpr (requires { sink.edge(s.i, s.j, n.data(), PairTangent<double>{}); }) {
        sink.edge(s.i, s.j, n.data(), {along, across});
      } else {
        const Eigen::Matrix3d B = across * Eigen::Matrix3d::Identity() + (along - across) * n * n.transpose();
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) {
            sink.position(3 * s.i + a, 3 * s.j + b, B(a, b));
            sink.position(3 * s.j + a, 3 * s.i + b, B(a, b));
            sink.position(3 * s.i + a, 3 * s.i + b, -B(a, b));
            sink.position(3 * s.j + a, 3 * s.j + b, -B(a, b));
          }
      }
    }
  }
};

void check_linear_net(auto scheme) {
  Net<3> net(40);
  for (Spring& s : net.springs) s.length = 0;  // f = k d: linear
  auto y = net.state;
  PhiStepper stepper{y, spring_network<3>(net.springs), scheme, mass(net.masses), newton({.linear_rtol = 1e-12})};
  REQUIRE(stepper.step(y, 0, 0.1));
  const Statistics first = stepper.statistics();
  CHECK(first.jacobians == 1);
  CHECK(first.analyses == 1);
  CHECK(first.factorizations == 1);
  CHECK(first.solves == first.iterations);
  CHECK(first.force_calls == first.iterations);
  CHECK(first.linear_iterations > 0);
  CHECK(first.fallbacks == 0);
  REQUIRE(stepper.step(y, 0.1, 0.1));
  CHECK(stepper.statistics().factorizations == 1);
  REQUIRE(stepper.step(y, 0.2, 0.05));
  CHECK(stepper.statistics().factorizations == 2);
  CHECK(stepper.statistics().jacobians == 1);
}

/// Of two factorizations and solves of one pattern.
inline void check_counts(const Statistics& counts) {
  CHECK(counts.analyses == 1);
  CHECK(counts.factorizations == 2);
  CHECK(counts.linear_iterations > 0);
  CHECK(counts.fallbacks == 0);
}

}  // namespace network_cases
