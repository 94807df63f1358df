// Differential-algebraic equations of index 1: orders, references, and what a run has around them.
#include <phistep/advise.hpp>
#include <phistep/io.hpp>
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

#include <sstream>

#include "problems/dae.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Three = Eigen::Vector3d;

namespace {
/// y = e^{−t}, z = cos t, w = e^{−2t} solve
///
///     y' = −y + (z − cos t) y,   0 = z + y² − w − cos t,   0 = w (3 − z) − y² (3 − cos t).
Three psi(const Three& u, double t) {
  const double c = std::cos(t), y = u[0], z = u[1], w = u[2];
  return {-y + (z - c) * y, z + y * y - w - c, w * (3 - z) - y * y * (3 - c)};
}
Three exact(double t) { return {std::exp(-t), std::cos(t), std::exp(-2 * t)}; }
constexpr auto known = [](const Three& u, double t) -> Three { return psi(u, t); };
struct WithJacobian {
  Three operator()(const Three& u, double t) const { return psi(u, t); }
  Eigen::Matrix3d jacobian(const Three& u, double t) const {
    const double c = std::cos(t), y = u[0], z = u[1], w = u[2];
    return Eigen::Matrix3d{{z - c - 1, y, 0}, {2 * y, 1, -1}, {-2 * y * (3 - c), -w, 3 - z}};
  }
};
const Three one_of_three{1, 0, 0};

/// Errors of differential and algebraic components at t = 1, by n steps.
template <class Scheme, class Mass>
std::array<double, 2> errors(Scheme scheme, const Mass& mass, int n) {
  Three y = exact(0);
  PhiStepper stepper{y, WithJacobian{}, scheme, mass};
  REQUIRE(integrate(stepper, y, {0.0, 1.0}, fixed(1.0 / n)));
  const Three off = (y - exact(1)).cwiseAbs();
  return {off[0], std::max(off[1], off[2])};
}
void check_order(double coarse, double fine, double order) {
  const double measured = std::log2(coarse / fine);
  CAPTURE(coarse, fine, measured);
  CHECK(measured > order - 0.25);
  CHECK(measured < order + 0.45);
}
template <class Scheme>
void check_orders(Scheme scheme, double order, int n) {
  // The same M three ways.
  const auto check = [&](const auto& mass) {
    const auto coarse = errors(scheme, mass, n), fine = errors(scheme, mass, 2 * n);
    check_order(coarse[0], fine[0], order);
    check_order(coarse[1], fine[1], order);
  };
  check(capacity(one_of_three));
  check(capacity(Eigen::Matrix3d(one_of_three.asDiagonal())));
  check(capacity(Eigen::SparseMatrix<double>(Eigen::Matrix3d(one_of_three.asDiagonal()).sparseView())));
}
}  // namespace

TEST_CASE("orders of convergence, differential and algebraic components apart") {
  check_orders(rodas4, 4, 64);
  check_orders(rodas4p2, 4, 64);
  check_orders(rodas5p, 5, 16);
  check_orders(radau, 5, 8);
  check_orders(tr_bdf2, 2, 40);
  check_orders(backward_euler, 1, 80);
  check_orders(phi_stage(1.0), 1, 80);
}

TEST_CASE("schemes that need M⁻¹ refuse a singular M and name a component") {
  Three y = exact(0);
  const auto refused = [&y](auto scheme, auto... solver) {
    CHECK_THROWS_WITH((PhiStepper{y, known, scheme, capacity(one_of_three), solver...}),
                      contains("component 1 of block 0"));
  };
  refused(forward_euler);
  refused(trapezoidal);
  refused(phi(0.5));
  refused(phi(0.9));
  refused(midpoint);
  refused(phi_stage(0.75));
  refused(rannacher);
  refused(extrapolated(forward_euler));
  refused(tsit5);
  refused(backward_euler, fixed_point());
  const auto taken = [&y](auto scheme) { PhiStepper{y, known, scheme, capacity(one_of_three)}; };
  taken(rodas4), taken(rodas5p), taken(tr_bdf2), taken(backward_euler), taken(phi(1.0)), taken(phi_stage(1.0)),
      taken(radau);
  // Motion has none: its masses are what forces act on.
  const Motion m{Three::Zero().eval(), Three::Zero().eval()};
  const auto pull = [](const Three& r) -> Three { return -r; };
  CHECK_THROWS_WITH((PhiStepper{m, pull, backward_euler, mass(one_of_three)}), contains("must be > 0"));
  CHECK_THROWS_AS(capacity(0.0), std::invalid_argument);
}

TEST_CASE("Robertson's reactions, the transistor amplifier and a pendulum come to their references") {
  const auto error = []<class Problem>(Problem, auto force, auto scheme, double tol, double atol) {
    typename Problem::State y = Problem::start();
    PhiStepper stepper{y, force, scheme, capacity(Problem::mass())};
    REQUIRE(integrate(stepper, y, {0.0, Problem::t1}, tolerance{.rtol = tol, .atol = tol * atol}));
    const auto end = Problem::end();
    return ((y - end).cwiseAbs().array() / (end.cwiseAbs().array() + atol)).maxCoeff();
  };
  using namespace problems;
  const AutonomousDaeForce<RobertsonDae> robertson;
  CHECK(error(RobertsonDae{}, robertson, rodas4, 1e-6, 1e-6) <= 1e-6);
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
  const auto check = [](auto scheme, double tightest, double within) {
    for (double tol = 1e-3; tol >= tightest; tol /= 10) {
      Three y = exact(0);
      PhiStepper stepper{y, known, scheme, capacity(one_of_three)};
      REQUIRE(integrate(stepper, y, {0.0, 2.0}, tolerance{.rtol = tol, .atol = tol}));
      const double error = (y - exact(2)).cwiseAbs().maxCoeff() / tol;
      CAPTURE(tol, error);
      CHECK(error <= within);
      CHECK(error >= 1e-4);
    }
  };
  check(rodas4, 1e-9, 10);
  check(rodas5p, 1e-9, 10);
  check(radau, 1e-9, 10);
  check(tr_bdf2, 1e-6, 10);
  check(backward_euler, 1e-4, 10);
  check(phi_stage(1.0), 1e-4, 10);
}

TEST_CASE("samples and events of algebraic components") {
  const auto check = [](auto scheme, double tol) {
    const auto run = [&](const auto& control, double allowed) {
      Three y = exact(0);
      PhiStepper stepper{y, known, scheme, capacity(one_of_three)};
      double worst = 0, found = 0;
      const auto look = [&](double t, const Three& u) {
        worst = std::max(worst, (u - exact(t)).cwiseAbs().maxCoeff());
      };
      auto crossing =
          event([](double, const Three& u) { return u[1] - 0.3; }, [&](double t, const Three&) { found = t; });
      REQUIRE(integrate(stepper, y, {0.0, 2.0}, control, sampled(0.01, look), crossing));
      CHECK(worst <= allowed);
      CHECK(std::abs(found - std::acos(0.3)) <= allowed);
    };
    run(tolerance{.rtol = tol, .atol = tol}, 10 * tol);
    run(fixed(0.02), 100 * tol);
  };
  check(rodas4, 1e-6);
  check(rodas5p, 1e-6);
  check(tr_bdf2, 1e-4);
}

TEST_CASE("a run goes on from a checkpoint bit for bit") {
  const auto check = [](auto scheme, const auto& control) {
    Three y = exact(0), z = exact(0);
    PhiStepper one{y, known, scheme, capacity(one_of_three)}, other{z, known, scheme, capacity(one_of_three)};
    Run first{one, y, {0.0, 1.0}, control}, second{other, z, {0.0, 1.0}, control};
    for (int n = 0; n < 4; ++n) REQUIRE(first.advance());
    std::stringstream file;
    save_checkpoint(file, first);
    load_checkpoint(file, second);
    CHECK(first.finish().outcome == Outcome::success);
    CHECK(second.finish().outcome == Outcome::success);
    CHECK(y == z);
    CHECK(one.statistics().force_calls == other.statistics().force_calls);
  };
  check(rodas4, tolerance{.rtol = 1e-6});
  check(rodas4, fixed(0.1));
  check(tr_bdf2, tolerance{.rtol = 1e-4});
  check(tr_bdf2, fixed(0.1));
  check(backward_euler, fixed(0.1));
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
