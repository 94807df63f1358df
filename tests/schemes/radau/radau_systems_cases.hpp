#pragma once

// What the quick and the full tests of Radau IIA over every kind of system share.
#include <phistep/schemes/radau/radau.hpp>
#include <phistep/sparse.hpp>

#include <algorithm>
#include <cmath>

#include "contract/restart_run.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

namespace radau_systems_cases {

using namespace phistep;
using problems::distance;
using Vec = Eigen::VectorXd;

/// A chain of n: y_i' = D (y_{i−1} − 2y_i + y_{i+1}) − y_i³ + sin t, zero beyond the ends.
template <Structure of>
struct Chain : ForceTerm {
  static constexpr Structure structure = of;
  static constexpr int block = 2;
  double D;
  explicit Chain(double diffusion = 40) : D{diffusion} {}
  static Vec start(int n = 12) { return Vec::LinSpaced(n, 1, -0.5); }
  void add(auto t, const auto& state, auto& out) const {
    const auto& y = state.y;
    const auto n = y.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      const double left = i > 0 ? y[i - 1] : 0, right = i + 1 < n ? y[i + 1] : 0;
      out.rate[i] += D * (left - 2 * y[i] + right) - y[i] * y[i] * y[i] + std::sin(t);
    }
  }
  void add_jacobian(auto /*t*/, const auto& state, auto& sink) const {
    const auto n = state.y.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      sink.rate(i, i, -2 * D - 3 * state.y[i] * state.y[i]);
      if (i > 0) sink.rate(i, i - 1, D);
      if (i + 1 < n) sink.rate(i, i + 1, D);
    }
  }
};
/// The same as a lambda, for differences.
inline const auto chain = [](const Vec& y, double t) -> Vec {
  Vec out = Vec::Zero(y.size());
  struct View {
    const Vec& y;
  };
  struct Rate {
    Vec& rate;
  } to{out};
  Chain<Structure::dense>{}.add(t, View{y}, to);
  return out;
};

/// Beads on a line with neighbours, r'' = −∂V/∂r − v/5: a motion whose tangents are bands.
template <Structure of>
struct Beads : ForceTerm {
  static constexpr Structure structure = of;
  static constexpr int block = 2;
  static Motion<Vec> start(int n = 10) { return {Vec::LinSpaced(n, 0.3, -0.2), Vec::Zero(n)}; }
  void add(auto /*t*/, const auto& state, auto& out) const {
    const auto& r = state.r;
    const auto n = r.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      const double left = i > 0 ? r[i - 1] : 0, right = i + 1 < n ? r[i + 1] : 0;
      out.force[i] += 30 * (left - 2 * r[i] + right) - 4 * r[i] * r[i] * r[i] - 0.2 * state.v[i];
    }
  }
  void add_jacobian(auto /*t*/, const auto& state, auto& sink) const {
    const auto n = state.r.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      sink.position(i, i, -60 - 12 * state.r[i] * state.r[i]);
      sink.velocity(i, i, -0.2);
      if (i > 0) sink.position(i, i - 1, 30);
      if (i + 1 < n) sink.position(i, i + 1, 30);
    }
  }
};

/// y' = λy
struct Grow : ForceTerm {
  double lambda;
  explicit Grow(double l) : lambda{l} {}
  void add(auto, const auto& state, auto& out) const { out.rate += lambda * state.y; }
  void add_jacobian(auto, const auto& state, auto& sink) const {
    for (Eigen::Index i = 0; i < state.y.size(); ++i) sink.rate(i, i, lambda);
  }
};
struct Band : Grow {
  static constexpr Structure structure = Structure::banded;
  using Grow::Grow;
};
struct Net : Grow {
  static constexpr Structure structure = Structure::sparse;
  using Grow::Grow;
};

struct Ended {
  Vec y;
  Statistics counts;
};
template <class State>
Ended controlled(State y, auto force, double rtol, auto... options) {
  PhiStepper stepper{y, force, radau, options...};
  const RunReport report = integrate(stepper, y, {0, 2}, tolerance{.rtol = rtol, .atol = 1e-3 * rtol});
  INFO(report.message());
  REQUIRE(report);
  Vec end;
  if constexpr (requires { y.r; }) {
    end.resize(2 * y.r.size());
    end << y.r, y.v;
  } else {
    end = y;
  }
  return {end, report.statistics};
}
inline void check_same(const Ended& a, const Ended& b) {
  CHECK((a.y - b.y).lpNorm<Eigen::Infinity>() <= 1e-12);
  CHECK(a.counts.steps == b.counts.steps);
  CHECK(a.counts.iterations == b.counts.iterations);
  CHECK(a.counts.jacobians == b.counts.jacobians);
  CHECK(a.counts.factorizations == b.counts.factorizations);
  CHECK(a.counts.force_calls == b.counts.force_calls);
}
/// The order of convergence, from errors of `least` and twice as many steps.
void check_order(auto force, auto start, int stages, int least, double expected) {
  const auto run = [&](int n) {
    PhiStepper stepper{start, force, radau(stages)};
    const auto y = problems::march(stepper, start, 0.0, 1.0, n);
    if constexpr (requires { y.r; }) return y.r;
    else return y;
  };
  const Vec reference = run(16 * least);
  const double coarse = distance(run(least), reference), fine = distance(run(2 * least), reference);
  CAPTURE(stages, coarse, fine);
  CHECK(std::abs(std::log2(coarse / fine) - expected) <= 0.8);
}
/// A run whose Jacobian is found by differences over a declared pattern: that of the dense one, three colours a Jacobian.
void check_close(auto force, const Ended& dense) {
  const Ended run = controlled(Chain<Structure::dense>::start(), force, 1e-8);
  CHECK((run.y - dense.y).lpNorm<Eigen::Infinity>() <= 1e-7);
  CHECK(run.counts.force_calls >= 4 * run.counts.jacobians);
  CHECK(run.counts.steps <= dense.counts.steps + 2);
}
inline Eigen::SparseMatrix<double> tridiagonal() {
  Eigen::SparseMatrix<double> pattern(12, 12);
  for (int i = 0; i < 12; ++i)
    for (int j = std::max(0, i - 1); j < std::min(12, i + 2); ++j) pattern.insert(i, j) = 1;
  return pattern;
}

}  // namespace radau_systems_cases
