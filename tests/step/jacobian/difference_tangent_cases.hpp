#pragma once

// What the quick and the full half of step/jacobian/difference_tangent share.
#include <phistep/sparse.hpp>

#include <cmath>
#include <functional>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;
using states::same_bits;

namespace difference_tangent_cases {

/// u_t = Δ_h u with u = 0 beyond both ends.
inline Vec heat(const Vec& u) {
  const Eigen::Index n = u.size();
  Vec rate = -2 * u;
  rate.head(n - 1) += u.tail(n - 1);
  rate.tail(n - 1) += u.head(n - 1);
  return 50 * rate;
}
inline Sparse tridiagonal(int n) {
  Sparse A(n, n);
  for (int j = 0; j < n; ++j)
    for (int i = std::max(0, j - 1); i < std::min(n, j + 2); ++i) A.insert(i, j) = i == j ? -100 : 50;
  return A;
}
inline Vec wave(Eigen::Index n) { return Vec::LinSpaced(n, 0, 7).array().sin(); }

/// Nonlinear springs between neighbours and dashpots; both tangents are tridiagonal.
inline Vec chain(const Vec& r, const Vec& v) {
  const Eigen::Index n = r.size();
  Vec force = -0.3 * v;
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    const double stretch = r[i + 1] - r[i], f = stretch + 4 * stretch * stretch * stretch + 0.1 * (v[i + 1] - v[i]);
    force[i] += f;
    force[i + 1] -= f;
  }
  return force;
}

/// Particles whose temperature slows them and that heat by friction: K, and C with two coupled blocks.
struct Warm {
  Vec r, v, T;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v, y.T); }
  struct Rate {
    Vec force, heat;
    static auto blocks(auto& rate) { return std::tie(rate.force, rate.heat); }
  };
};
struct Friction : ForceTerm {
  static void add(double, const auto& y, auto& out) {
    out.force.array() += -y.r.array() - (1 + y.T.array()) * y.v.array();
    out.heat.array() += (1 + y.T.array()) * y.v.array().square() - 3 * y.T.array();
  }
};
/// Component i of the force depends on r_i, v_i and T_i; so does component n + i, the heat.
struct PatternedFriction : Friction {
  static constexpr Structure structure = Structure::sparse;
  static ColumnPattern pattern(Eigen::Index n) {
    ColumnPattern pattern;
    for (Eigen::Index j = 0; j < n; ++j) {
      pattern.row.push_back(j % (n / 2));
      pattern.row.push_back(n / 2 + j % (n / 2));
      pattern.start.push_back(2 * (j + 1));
    }
    return pattern;
  }
};

struct Coupled {
  static constexpr Structure structure = Structure::sparse;
  Eigen::Index reach;
  Vec operator()(const Vec& u) const {
    Vec rate = -u;
    rate.head(u.size() - reach) += 0.5 * u.tail(u.size() - reach);
    return rate;
  }
  [[nodiscard]] ColumnPattern pattern(Eigen::Index n) const { return band_pattern(n, 0, reach); }
};

/// Steps with Newton and counts. The force at a step's start is one call beside those of its iterations.
template <class State>
Statistics steps(State& y, auto force, auto scheme, int count, const auto&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < count; ++k) {
    const StepReport report = stepper.step(y, 0.1 * k, 0.1);
    INFO(report.message());
    REQUIRE(report);
  }
  return stepper.statistics();
}

}  // namespace difference_tangent_cases
