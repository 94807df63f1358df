// The same problem in other units. Where length, mass, time and tolerances are scaled by powers of two, every number is
// scaled exactly, and so nothing may change: no bit of the state (scaled back) and no counter. A constant with a hidden
// unit anywhere in the library shows here. In short; every scheme and solver: units*.full.cpp.
#include "acceptance/units_cases.hpp"

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
