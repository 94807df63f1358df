#pragma once

// What the files assess_*.full.cpp and their quick half, tests/study/preflight.test.cpp, share.

#include <phistep/preflight.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "instances/preflight.hpp"
#include "support/catch.hpp"

namespace assess_cases {

using namespace phistep;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

inline constexpr double infinite = std::numeric_limits<double>::infinity(),
                        nan_value = std::numeric_limits<double>::quiet_NaN();

inline std::vector<Spring> chain(int n, double k) {
  std::vector<Spring> springs;
  for (int i = 0; i + 1 < n; ++i) springs.push_back({i, i + 1, k, 1.0});
  return springs;
}
inline Motion<Vec> chain_state(int n) { return {Vec::LinSpaced(n, 0, n - 1), Vec::Zero(n)}; }
/// −k × (the chain's differences), all of it linear.
inline Sparse chain_matrix(int n, double k) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i + 1 < n; ++i)
    for (const auto& [a, b, x] : {std::tuple{i, i, -k}, {i + 1, i + 1, -k}, {i, i + 1, k}, {i + 1, i, k}})
      entries.emplace_back(a, b, x);
  Sparse K(n, n);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}
struct ChainForce {
  double k;
  Vec operator()(const Vec& r) const {
    Vec f = Vec::Zero(r.size());
    for (Eigen::Index i = 0; i + 1 < r.size(); ++i) {
      const double pull = k * (r[i + 1] - r[i] - 1);
      f[i] += pull, f[i + 1] -= pull;
    }
    return f;
  }
};
inline bool mentions(const PreflightReport& report, const std::string& what) {
  return report.text().find(what) != std::string::npos;
}

/// @param ask  of a chain of five, springs of 1, by Verlet
inline void check_nonsense(const std::function<PreflightReport(const Motion<Vec>&, double dt)>& ask) {
  auto y = chain_state(5);
  for (const double dt : {0.0, -1.0, nan_value, infinite}) {
    const auto report = ask(y, dt);
    CHECK(report.verdict == Verdict::invalid);
    CHECK(mentions(report, "dt is not positive and finite"));
    CHECK(report.stable_dt > 1);  // known all the same
    CHECK(std::isfinite(report.recommended.dt));
  }
  y.v[3] = nan_value;
  CHECK(ask(y, 0.1).verdict == Verdict::unknown);
  CHECK(mentions(ask(y, 0.1), "state is not finite"));
  y = chain_state(5);
  y.r[2] = infinite;
  CHECK(ask(y, 0.1).verdict == Verdict::unknown);
}

template <class Stepper>
void check_nothing_stepped(Stepper& stepper, Motion<Vec>& y) {
  REQUIRE(stepper.step(y, 0, 0.1));
  const Statistics counts = stepper.statistics();
  auto twin = stepper;
  auto other = y;
  static_cast<void>(preflight(stepper, y, 0.1));
  CHECK(stepper.statistics() == counts);
  REQUIRE(stepper.step(y, 0.1, 0.1));
  REQUIRE(twin.step(other, 0.1, 0.1));
  CHECK(equal_blocks<Motion<Vec>>(y, other));
  CHECK(stepper.statistics() == twin.statistics());
}

/// Of a chain of n, springs of 8 and masses of 2.
inline void check_structure(const char* name, int n, const PreflightReport& report, double rounding) {
  const double k = 8, m = 2, omega = 2 * std::sqrt(k / m) * std::cos(std::numbers::pi / (2 * n));
  INFO(name << ", " << n << " particles");
  CHECK(report.whole.exact == (2 * n <= 200));
  CHECK(report.whole.frequency >= omega * (1 - rounding));
  CHECK(report.whole.frequency <= 2 * std::sqrt(k / m) * (1 + rounding));
  if (report.whole.exact) CHECK(report.whole.frequency == Approx(omega).epsilon(rounding));
  CHECK(report.whole.damping == 0);
}

/// @param two  the same scene with a unit of time 2^41 times as long
inline void check_units(const PreflightReport& one, const PreflightReport& two) {
  CHECK(two.stable_dt == one.stable_dt * 0x1p-41);
  CHECK(two.accurate_dt == one.accurate_dt * 0x1p-41);
  CHECK(two.whole.frequency == one.whole.frequency * 0x1p41);
  CHECK(two.whole.damping == one.whole.damping * 0x1p41);
  CHECK(two.phase_error == one.phase_error);
  CHECK(two.verdict == one.verdict);
}

}  // namespace assess_cases
