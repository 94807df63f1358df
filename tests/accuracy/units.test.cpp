// The same problem in other units. Where length, mass, time and tolerances are scaled by powers of two, every number is
// scaled exactly, and so nothing may change: no bit of the state (scaled back) and no counter. A constant with a hidden
// unit anywhere in the library shows here. In short; every scheme and solver: the stress tier.
#include "accuracy/units_cases.hpp"

#if PHISTEP_FULL

TEST_CASE("units: explicit schemes and Verlet") { check_motion(velocity_verlet, elastic_chain, to_rounding, 0.02, 50); }

TEST_CASE("units: Newton to rounding, by differences") { check_motion(backward_euler, chain, to_rounding, 0.5, 20); }

TEST_CASE("units: Newton to a tolerance, damped, once") { check_motion(backward_euler, chain, to_tolerance, 0.1, 60); }

TEST_CASE("units: steps that are halved") {
  check_all([](const Units& u) {
    Scene scene{u};
    Halving stepper{PhiStepper{scene.y, chain(u), backward_euler, mass(scene.masses), newton({.max_iterations = 4})},
                    12};
    auto result = march(stepper, scene, 0.5, 10);
    CHECK(result.counts.halvings > 0);
    return result;
  });
}

TEST_CASE("units: runs that choose their own steps, the first one included") {
  check_all([&](const Units& u) {
    Scene scene{u};
    PhiStepper stepper{scene.y, chain(u), backward_euler, mass(scene.masses)};
    const auto control = tolerance{.rtol = 1e-3, .first_step = u.of(0.01, 0, 0, 1), .max_step = u.of(0.1, 0, 0, 1)};
    const auto report = integrate(stepper, scene.y, {0.0, u.of(3, 0, 0, 1)}, control);
    Result result{describe(report.outcome), scene.numbers(), report.statistics};
    result.numbers.conservativeResize(result.numbers.size() + 3);
    result.numbers.tail<3>() << std::ldexp(report.smallest_dt, -u.time), std::ldexp(report.largest_dt, -u.time),
        std::ldexp(report.t, -u.time);
    return result;
  });
}

TEST_CASE("units: a run from rest, whose first step only the atol tells") { check_from_rest(backward_euler); }

#elif PHISTEP_STRESS
// The same problem in other units: steps of one length, dense.

TEST_CASE("units: explicit schemes and Verlet") {
  check_motion(forward_euler, chain, to_rounding, 0.01, 50);
  check_motion(symplectic_euler, elastic_chain, to_rounding, 0.02, 50);
  check_motion(velocity_verlet, elastic_chain, to_rounding, 0.02, 50);
  check_motion(velocity_verlet, chain, to_rounding, 0.02, 50);  // solves for v
}

TEST_CASE("units: Newton to rounding, by differences") {
  check_motion(trapezoidal, chain, to_rounding, 0.1, 40);
  check_motion(trapezoidal, elastic_chain, to_rounding, 0.3, 40);
  check_motion(backward_euler, chain, to_rounding, 0.5, 20);
  check_motion(midpoint, chain, to_rounding, 0.1, 40);
  check_motion(phi(0.7), chain, to_rounding, 0.1, 40);
  check_motion(phi(0.7, 0.4), chain, to_rounding, 0.05, 40);
  check_motion(tr_bdf2, chain, to_rounding, 0.2, 40);
  check_motion(rannacher(2), chain, to_rounding, 0.1, 20);
}

TEST_CASE("units: Newton to rounding, with an analytic Jacobian") {
  check_motion(trapezoidal, tangent_chain, to_rounding, 0.1, 40);
  check_motion(backward_euler, tangent_chain, to_rounding, 5, 20);
  check_motion(midpoint, tangent_chain, to_rounding, 0.1, 40);
}

TEST_CASE("units: Newton to a tolerance, damped, once") {
  check_motion(tr_bdf2, chain, to_tolerance, 0.1, 60);
  check_motion(trapezoidal, tangent_chain, to_tolerance, 0.1, 60);
  const auto damped = [](const Units&) { return newton({.line_search = true}); };
  check_motion(backward_euler, tangent_chain, damped, 2, 10);
  const auto once = [](const Units&) { return linearly_implicit(); };
  check_motion(trapezoidal, chain, once, 0.05, 40);
}

TEST_CASE("units: fixed-point iteration, plain and accelerated, to rounding and to a tolerance") {
  const auto solver = [](const Units&) { return fixed_point(); };
  const auto plain = [](const Units&) { return fixed_point({.depth = 0}); };
  const auto told = [](const Units& u) { return fixed_point({.rtol = 1e-4, .atol = u.of(1e-5, 1, 0, -1)}); };
  check_motion(trapezoidal, chain, solver, 0.05, 40);
  check_motion(trapezoidal, chain, plain, 0.05, 40);
  check_motion(tr_bdf2, chain, told, 0.05, 40);
}

#endif
