// The same problem in other units: states of first order, runs that choose their steps. In short: units.test.cpp.
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include "accuracy/units_cases.hpp"

TEST_CASE("units: first-order states") {
  const auto check = [](auto scheme, auto&& force, auto&& solver) {
    check_all([&](const Units& u) {
      Rod rod{u};
      PhiStepper stepper{rod.y, force(rod), scheme, capacity(rod.capacity()), solver(u)};
      return march(stepper, rod, 0.02, 25);
    });
  };
  const auto dense = [](const Rod& rod) { return rod.force(); };
  const auto band = [](const Rod& rod) { return banded(rod.force(), 1, 1); };
  const auto told = [](const Units& u) { return newton({.rtol = 1e-4, .atol = u.of(1e-6, 1, 0, 0)}); };
  check(forward_euler, dense, to_rounding);
  check(trapezoidal, dense, to_rounding);
  check(rannacher(2), band, to_rounding);
  check(tr_bdf2, band, told);
  check(backward_euler, dense, [](const Units&) { return fixed_point(); });
}

TEST_CASE("units: runs that choose their own steps, the first one included") {
  const auto check = [](auto scheme, auto&& control) {
    check_all([&](const Units& u) {
      Scene scene{u};
      PhiStepper stepper{scene.y, chain(u), scheme, mass(scene.masses)};
      double last = 0, steps = 0;
      const auto report = integrate(stepper, scene.y, {0.0, u.of(3, 0, 0, 1)}, control(u), [&](double t, const auto&) {
        steps += std::ldexp(t - last, -u.time);
        last = t;
      });
      Result result{describe(report.outcome), scene.numbers(), report.statistics};
      result.numbers.conservativeResize(result.numbers.size() + 4);
      result.numbers.tail<4>() << steps, std::ldexp(report.smallest_dt, -u.time),
          std::ldexp(report.largest_dt, -u.time), std::ldexp(report.t, -u.time);
      return result;
    });
    check_all([&](const Units& u) {
      Rod rod{u};
      if constexpr (requires { PhiStepper{rod.y, rod.force(), scheme}; }) {
        PhiStepper stepper{rod.y, rod.force(), scheme, capacity(rod.capacity())};
        const auto report = integrate(stepper, rod.y, {0.0, u.of(1, 0, 0, 1)}, control(u));
        return Result{describe(report.outcome), rod.numbers(), report.statistics};
      } else {
        return Result{"", Vec::Ones(1), {}};
      }
    });
  };
  const auto relative = [](const Units&) { return tolerance{.rtol = 1e-4}; };
  const auto bounded = [](const Units& u) {
    return tolerance{.rtol = 1e-3, .first_step = u.of(0.01, 0, 0, 1), .max_step = u.of(0.1, 0, 0, 1)};
  };
  check(trapezoidal, relative);
  check(backward_euler, bounded);
  check(tr_bdf2, relative);
  check(midpoint, relative);
}

TEST_CASE("units: steps ruled by iterations, or by both; solves by fixed points to the run's own tolerance") {
  const auto by_iterations = [](const Units& u) {
    return iteration_control{.first_step = u.of(0.01, 0, 0, 1), .max_step = u.of(0.5, 0, 0, 1)};
  };
  const auto check = [](auto&& control, auto&& solver) {
    check_all([&](const Units& u) {
      Scene scene{u};
      PhiStepper stepper{scene.y, chain(u), trapezoidal, mass(scene.masses), solver(u)};
      const auto report = integrate(stepper, scene.y, {0.0, u.of(2, 0, 0, 1)}, control(u));
      return Result{describe(report.outcome), scene.numbers(), report.statistics};
    });
  };
  const auto plain = [](const Units& u) {
    return fixed_point({.rtol = 1e-4, .atol = u.of(1e-5, 1, 0, -1), .depth = 0});
  };
  check(by_iterations, plain);
  check([&](const Units& u) { return smaller_of(tolerance{.rtol = 1e-3}, by_iterations(u)); }, plain);
  check([](const Units&) { return tolerance{.rtol = 1e-5}; }, [](const Units&) { return fixed_point(); });
  check([](const Units&) { return tolerance{.rtol = 1e-5}; }, [](const Units&) { return newton<MatrixFree<>>(); });
}

TEST_CASE("units: a run with an atol of its own") {
  check_all([](const Units& u) {
    Rod rod{u};
    PhiStepper stepper{rod.y, banded(rod.force(), 1, 1), tr_bdf2, capacity(rod.capacity())};
    const auto report =
        integrate(stepper, rod.y, {0.0, u.of(1, 0, 0, 1)}, tolerance{.rtol = 1e-5, .atol = u.of(1e-7, 1, 0, 0)});
    return Result{describe(report.outcome), rod.numbers(), report.statistics};
  });
}

TEST_CASE("units: a run from rest, whose first step only the atol tells") { check_from_rest(tr_bdf2); }
