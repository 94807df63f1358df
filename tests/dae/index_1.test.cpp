// Differential-algebraic equations of index 1: orders, references, and what a run has around them. Other forms of M with
// other schemes, and other references: index_1.full.
#include "dae/index_1_cases.hpp"

using namespace index_1_cases;

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
