// Differential-algebraic equations of index 1: orders, references, and what a run has around them. Other forms of M with
// other schemes, and other references: the stress tier.
#include <phistep/advise.hpp>
#include <phistep/io.hpp>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <sstream>

#include "problems/dae.hpp"
#include "support/catch.hpp"

namespace index_1_cases {

using namespace phistep;
using Three = Eigen::Vector3d;

/// y = e^{−t}, z = cos t, w = e^{−2t} solve
///
///     y' = −y + (z − cos t) y,   0 = z + y² − w − cos t,   0 = w (3 − z) − y² (3 − cos t).
inline Three psi(const Three& u, double t) {
  const double c = std::cos(t), y = u[0], z = u[1], w = u[2];
  return {-y + (z - c) * y, z + y * y - w - c, w * (3 - z) - y * y * (3 - c)};
}
inline Three exact(double t) { return {std::exp(-t), std::cos(t), std::exp(-2 * t)}; }
inline constexpr auto known = [](const Three& u, double t) -> Three { return psi(u, t); };
struct WithJacobian {
  Three operator()(const Three& u, double t) const { return psi(u, t); }
  Eigen::Matrix3d jacobian(const Three& u, double t) const {
    const double c = std::cos(t), y = u[0], z = u[1], w = u[2];
    return Eigen::Matrix3d{{z - c - 1, y, 0}, {2 * y, 1, -1}, {-2 * y * (3 - c), -w, 3 - z}};
  }
};
inline const Three one_of_three{1, 0, 0};

/// Errors of differential and algebraic components at t = 1, by n steps.
template <class Scheme, class Mass>
std::array<double, 2> errors(Scheme scheme, const Mass& mass, int n) {
  Three y = exact(0);
  PhiStepper stepper{y, WithJacobian{}, scheme, mass};
  REQUIRE(integrate(stepper, y, {0.0, 1.0}, fixed(1.0 / n)));
  const Three off = (y - exact(1)).cwiseAbs();
  return {off[0], std::max(off[1], off[2])};
}
inline void check_order(double coarse, double fine, double order) {
  const double measured = std::log2(coarse / fine);
  CAPTURE(coarse, fine, measured);
  CHECK(measured > order - 0.25);
  CHECK(measured < order + 0.45);
}
/// @param mass  M = diag(1, 0, 0) in one form or several
template <class Scheme, class... Mass>
void check_orders(Scheme scheme, double order, int n, const Mass&... mass) {
  const auto check = [&](const auto& M) {
    const auto coarse = errors(scheme, M, n), fine = errors(scheme, M, 2 * n);
    check_order(coarse[0], fine[0], order);
    check_order(coarse[1], fine[1], order);
  };
  (check(mass), ...);
}
inline const auto diagonal = capacity(one_of_three);
inline const auto dense = capacity(Eigen::Matrix3d(one_of_three.asDiagonal()));
inline const auto sparse =
    capacity(Eigen::SparseMatrix<double>(Eigen::Matrix3d(one_of_three.asDiagonal()).sparseView()));

/// The largest error of a run to the problem's end, relative above atol.
template <class Problem>
double error(Problem, auto force, auto scheme, double tol, double atol) {
  typename Problem::State y = Problem::start();
  PhiStepper stepper{y, force, scheme, capacity(Problem::mass())};
  REQUIRE(integrate(stepper, y, {0.0, Problem::t1}, tolerance{.rtol = tol, .atol = tol * atol}));
  const auto end = Problem::end();
  return ((y - end).cwiseAbs().array() / (end.cwiseAbs().array() + atol)).maxCoeff();
}
void check_tolerances(const auto& force, auto scheme, double tightest) {
  for (double tol = 1e-3; tol >= tightest; tol /= 10) {
    Three y = exact(0);
    PhiStepper stepper{y, force, scheme, capacity(one_of_three)};
    REQUIRE(integrate(stepper, y, {0.0, 2.0}, tolerance{.rtol = tol, .atol = tol}));
    const double off = (y - exact(2)).cwiseAbs().maxCoeff() / tol;
    CAPTURE(tol, off);
    CHECK(off <= 10);
    CHECK(off >= 1e-4);
  }
}
/// Samples and an event of an algebraic component, to the allowed error.
void check_samples(auto scheme, const auto& control, double allowed) {
  Three y = exact(0);
  PhiStepper stepper{y, WithJacobian{}, scheme, capacity(one_of_three)};
  double worst = 0, found = 0;
  const auto look = [&](double t, const Three& u) { worst = std::max(worst, (u - exact(t)).cwiseAbs().maxCoeff()); };
  auto crossing = event([](double, const Three& u) { return u[1] - 0.3; }, [&](double t, const Three&) { found = t; });
  REQUIRE(integrate(stepper, y, {0.0, 2.0}, control, sampled(0.01, look), crossing));
  CHECK(worst <= allowed);
  CHECK(std::abs(found - std::acos(0.3)) <= allowed);
}
/// A run that resumes a checkpoint, against the one that saved it.
void check_restart(auto scheme, const auto& control) {
  Three y = exact(0), z = exact(0);
  PhiStepper one{y, WithJacobian{}, scheme, capacity(one_of_three)},
      other{z, WithJacobian{}, scheme, capacity(one_of_three)};
  Run first{one, y, {0.0, 1.0}, control}, second{other, z, {0.0, 1.0}, control};
  for (int n = 0; n < 4; ++n) REQUIRE(first.advance());
  std::stringstream file;
  save_checkpoint(file, first);
  load_checkpoint(file, second);
  CHECK(first.finish().outcome == Outcome::success);
  CHECK(second.finish().outcome == Outcome::success);
  CHECK(y == z);
  CHECK(one.statistics().force_calls == other.statistics().force_calls);
}

}  // namespace index_1_cases

using namespace index_1_cases;

#if PHISTEP_FULL

TEST_CASE("orders of convergence, differential and algebraic components apart") {
  check_orders(rodas4, 4, 64, diagonal, dense);
  check_orders(rodas4p2, 4, 64, diagonal);
  check_orders(rodas5p, 5, 16, diagonal);
  check_orders(radau, 5, 8, diagonal);
  check_orders(tr_bdf2, 2, 40, diagonal);
  check_orders(backward_euler, 1, 80, diagonal);
  check_orders(phi_stage(1.0), 1, 80, diagonal);
}

TEST_CASE("schemes that need M⁻¹ refuse a singular M and name a component") {
  Three y = exact(0);
  const auto refused = [&y](auto scheme, auto... solver) {
    CHECK_THROWS_WITH((PhiStepper{y, WithJacobian{}, scheme, capacity(one_of_three), solver...}),
                      contains("component 1 of block 0"));
  };
  refused(forward_euler);
  refused(trapezoidal);
  refused(phi(0.5));
  refused(phi(0.9));
  refused(midpoint);
  refused(phi_stage(0.75));
  refused(rannacher);
  refused(tsit5);
  refused(backward_euler, fixed_point());
  const auto taken = [&y](auto scheme) { PhiStepper{y, WithJacobian{}, scheme, capacity(one_of_three)}; };
  taken(rodas4), taken(rodas5p), taken(tr_bdf2), taken(backward_euler), taken(phi(1.0)), taken(phi_stage(1.0)),
      taken(radau);
  // Motion has none: its masses are what forces act on.
  const Motion m{Three::Zero().eval(), Three::Zero().eval()};
  const auto pull = [](const Three& r) -> Three { return -r; };
  CHECK_THROWS_WITH((PhiStepper{m, pull, backward_euler, mass(one_of_three)}), contains("must be > 0"));
  CHECK_THROWS_AS(capacity(0.0), std::invalid_argument);
}

TEST_CASE("Robertson's reactions, the transistor amplifier and a pendulum come to their references") {
  const problems::AutonomousDaeForce<problems::RobertsonDae> robertson;
  CHECK(error(problems::RobertsonDae{}, robertson, rodas4, 1e-6, 1e-6) <= 1e-6);
}

TEST_CASE("the error goes with the tolerance, algebraic components included") {
  check_tolerances(known, rodas4, 1e-9);
  check_tolerances(WithJacobian{}, radau, 1e-9);
  check_tolerances(WithJacobian{}, tr_bdf2, 1e-6);
}

TEST_CASE("samples and events of algebraic components") {
  check_samples(rodas4, tolerance{.rtol = 1e-6, .atol = 1e-6}, 1e-5);
  check_samples(tr_bdf2, fixed(0.02), 1e-2);
}

TEST_CASE("a run goes on from a checkpoint bit for bit") {
  check_restart(rodas4, tolerance{.rtol = 1e-6});
  check_restart(tr_bdf2, fixed(0.1));
}

TEST_CASE("no scheme is advised for a singular M") {
  Three y = exact(0);
  CHECK_THROWS_WITH(advise(y, known, {0.0, 1.0}, {}, capacity(one_of_three)), contains("M is singular"));
}

TEST_CASE("exact counts of a fixed Δt") {
  const auto counts = [](auto scheme) {
    Three y = exact(0);
    PhiStepper stepper{y, known, scheme, capacity(one_of_three)};
    REQUIRE(integrate(stepper, y, {0.0, 1.0}, fixed(0.1)));
    return stepper.statistics();
  };
  // Six stages, three differences and two more for Ψ_t, a step.
  CHECK(counts(rodas4).force_calls == 110);
  CHECK(counts(rodas4).factorizations == 10);
  CHECK(counts(rodas4).solves == 60);
}

#elif PHISTEP_STRESS
// Differential-algebraic equations of index 1: the forms of M, references and Jacobians by differences that index_1.test leaves out.

TEST_CASE("orders of convergence, differential and algebraic components apart") {
  // One template steps for every Rosenbrock tableau, one for every φ: rodas4 and backward Euler stand for them.
  check_orders(rodas4, 4, 64, sparse);
  check_orders(radau, 5, 8, dense, sparse);
  check_orders(tr_bdf2, 2, 40, dense, sparse);
  check_orders(backward_euler, 1, 80, dense, sparse);
}

TEST_CASE("Robertson's reactions, the transistor amplifier and a pendulum come to their references") {
  using namespace problems;
  const AutonomousDaeForce<RobertsonDae> robertson;
  CHECK(error(RobertsonDae{}, robertson, rodas5p, 1e-10, 1e-6) <= 1e-9);
  CHECK(error(RobertsonDae{}, robertson, radau, 1e-7, 1e-6) <= 1e-7);
  CHECK(error(RobertsonDae{}, robertson, tr_bdf2, 1e-4, 1e-6) <= 1e-4);
  const AutonomousDaeForce<CartesianPendulum> pendulum;
  CHECK(error(CartesianPendulum{}, pendulum, rodas4, 1e-6, 1) <= 1e-5);
  CHECK(error(CartesianPendulum{}, pendulum, rodas5p, 1e-10, 1) <= 1e-9);
  CHECK(error(CartesianPendulum{}, pendulum, radau, 1e-8, 1) <= 1e-6);
  CHECK(error(CartesianPendulum{}, pendulum, tr_bdf2, 1e-4, 1) <= 1e-3);
  const DaeForce<TransistorAmplifier> amplifier;
  CHECK(error(TransistorAmplifier{}, amplifier, rodas4, 1e-4, 1) <= 1e-4);
  CHECK(error(TransistorAmplifier{}, amplifier, rodas5p, 1e-4, 1) <= 1e-4);
  CHECK(error(TransistorAmplifier{}, amplifier, radau, 1e-6, 1) <= 1e-5);
  CHECK(error(TransistorAmplifier{}, amplifier, tr_bdf2, 1e-3, 1) <= 1e-3);
}

TEST_CASE("the error goes with the tolerance, algebraic components included") {
  check_tolerances(known, radau, 1e-9);
  check_tolerances(known, tr_bdf2, 1e-6);
  check_tolerances(known, backward_euler, 1e-4);
  check_tolerances(WithJacobian{}, rodas5p, 1e-9);
  check_tolerances(WithJacobian{}, phi_stage(1.0), 1e-4);
}

TEST_CASE("samples and events of algebraic components") {
  check_samples(rodas4, fixed(0.02), 1e-4);
  check_samples(rodas5p, tolerance{.rtol = 1e-6, .atol = 1e-6}, 1e-5);
  check_samples(rodas5p, fixed(0.02), 1e-4);
  check_samples(tr_bdf2, tolerance{.rtol = 1e-4, .atol = 1e-4}, 1e-3);
}

TEST_CASE("a run goes on from a checkpoint bit for bit") {
  check_restart(rodas4, fixed(0.1));
  check_restart(tr_bdf2, tolerance{.rtol = 1e-4});
  check_restart(backward_euler, fixed(0.1));
}

#endif
