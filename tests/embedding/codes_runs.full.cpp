// Three existing codes in controlled runs: a tolerance, events do what they do with a state of the library under the same
// force.
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

using namespace codes_cases;

TEST_CASE("masses on springs under a tolerance") {
  after::Cloth code(36);
  before::Cloth other(36);
  check(code, other, phistep::velocity_verlet, phistep::mass(masses(other)), [](auto& stepper, auto& state) {
    return phistep::integrate(stepper, state, {0, 0.1}, phistep::tolerance{.rtol = 1e-5, .atol = 1e-7});
  });
}

TEST_CASE("an event ends the run of an existing code where it ends that of a state of the library") {
  after::Cloth code(36);
  before::Cloth other(36);
  check(
      code, other, phistep::velocity_verlet, phistep::mass(masses(other)),
      [](auto& stepper, auto& state) {
        return phistep::integrate(stepper, state, {0, 1}, phistep::fixed(1e-3),
                                  phistep::event([](const auto& y) { return y.r(2, 0) + 0.01; }, {.terminal = true}));
      },
      phistep::Outcome::stopped_by_event);
  CHECK(code.beads[0].x[2] == Approx(-0.01).margin(1e-12));
}

TEST_CASE("heat under a tolerance") {
  after::HeatPlate code(100);
  before::HeatPlate other(100);
  VectorXd y = VectorXd::Map(other.u, other.ncells);
  const auto rate = [&](const VectorXd& u) -> VectorXd {
    VectorXd::Map(other.u, other.ncells) = u;
    other.compute_rates();
    return VectorXd::Map(other.dudt, other.ncells);
  };
  const phistep::tolerance control{.rtol = 1e-4, .atol = 1e-6};
  phistep::PhiStepper by_library{y, rate, phistep::forward_euler};
  const auto right = phistep::integrate(by_library, y, {0, 0.1}, control);
  REQUIRE(right);
  in_place(code, [&](auto& state, auto force) {
    phistep::PhiStepper stepper{state, force, phistep::forward_euler};
    const auto report = phistep::integrate(stepper, state, {0, 0.1}, control);
    REQUIRE(report);
    CHECK(report.statistics.steps == right.statistics.steps);
    CHECK(report.statistics.force_calls == right.statistics.force_calls);
  });
  CHECK(distance(state_of(code), Numbers(y.begin(), y.end())) <= 1e-12);
}

// An existing code and a state of the library under the same force, by a scheme of order 8.

TEST_CASE("atoms under a tolerance, by a scheme of order 8") {
  after::MolecularDynamics code(64);
  before::MolecularDynamics other(64);
  check(code, other, phistep::rkn86, phistep::mass(1.0), [](auto& stepper, auto& state) {
    return phistep::integrate(stepper, state, {0, 0.1}, phistep::tolerance{.rtol = 1e-8, .atol = 1e-8});
  });
}
