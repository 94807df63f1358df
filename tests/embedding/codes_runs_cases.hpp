// What codes_runs.test.cpp and codes_runs.full.cpp share: a code and a state of the library in the same run.
#pragma once

#include "embedding/codes_cases.hpp"

namespace codes_cases {

using Eigen::Matrix3Xd, Eigen::VectorXd;

/// The code's arrays copied into a state of the library, its routine called on another instance of the code.
phistep::Motion<Matrix3Xd> motion_of(const auto& code) {
  const Numbers all = state_of(code);  // x, v, x, v …
  const auto n = static_cast<Eigen::Index>(all.size() / 6);
  const auto y = Eigen::Matrix<double, 6, Eigen::Dynamic>::Map(all.data(), 6, n);
  return {y.topRows<3>(), y.bottomRows<3>()};
}
inline Matrix3Xd forces(before::Cloth& cloth, const Matrix3Xd& r) {
  for (std::size_t i = 0; i < cloth.beads.size(); ++i)
    for (int k = 0; k < 3; ++k) cloth.beads[i].x[k] = r(k, static_cast<Eigen::Index>(i));
  cloth.compute_forces();
  const Numbers f = forces_of(cloth);
  return Matrix3Xd::Map(f.data(), 3, r.cols());
}
inline Matrix3Xd forces(before::MolecularDynamics& atoms, const Matrix3Xd& r) {
  for (int i = 0; i < atoms.natoms; ++i)
    for (int k = 0; k < 3; ++k) atoms.x[i][k] = r(k, i);
  atoms.compute_forces();
  const Numbers f = forces_of(atoms);
  return Matrix3Xd::Map(f.data(), 3, r.cols());
}
inline Numbers numbers_of(const phistep::Motion<Matrix3Xd>& y) {
  Numbers all(static_cast<std::size_t>(2 * y.r.size()));
  auto both = Eigen::Matrix<double, 6, Eigen::Dynamic>::Map(all.data(), 6, y.r.cols());
  both.topRows<3>() = y.r, both.bottomRows<3>() = y.v;
  return all;
}

/// What a run does, in both worlds: `go(stepper, state)` gives its report.
void check(auto& code, auto& other, auto scheme, const auto& mass, auto go,
           phistep::Outcome outcome = phistep::Outcome::success) {
  auto y = motion_of(other);
  phistep::PhiStepper by_library{y, [&](const Matrix3Xd& r) -> Matrix3Xd { return forces(other, r); }, scheme, mass};
  const auto right = go(by_library, y);
  REQUIRE(right.outcome == outcome);
  in_place(code, [&](auto& state, auto force) {
    phistep::PhiStepper stepper{state, force, scheme, mass_of(code)};
    const auto report = go(stepper, state);
    INFO(report.message());
    REQUIRE(report.outcome == outcome);
    CHECK(report.t == Approx(right.t).epsilon(1e-12));
    CHECK(report.statistics.steps == right.statistics.steps);
    CHECK(report.statistics.force_calls == right.statistics.force_calls);
    CHECK(report.statistics.rejections == right.statistics.rejections);
  });
  // The same formulas; what differs is how sums and norms are rounded, and with that Δt, a little.
  CHECK(distance(state_of(code), numbers_of(y)) <= 1e-10);
}

inline VectorXd masses(const before::Cloth& cloth) {
  VectorXd m(static_cast<Eigen::Index>(cloth.beads.size()));
  for (Eigen::Index i = 0; i < m.size(); ++i) m[i] = cloth.beads[static_cast<std::size_t>(i)].m;
  return m;
}

}  // namespace codes_cases
