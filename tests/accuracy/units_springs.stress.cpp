// The same problem in other units: networks of springs. In short: units.test.cpp.
#include <phistep/study/energy/energy_ledger.hpp>

#include "accuracy/units_cases.hpp"

TEST_CASE("units: networks of springs by conjugate gradients") {
  const auto check = [](auto scheme, double dt, auto&& solver, auto&& force) {
    check_all([&](const Units& u) {
      Net net{u};
      PhiStepper stepper{net.y, force(net), scheme, mass(net.masses), solver(u)};
      return march(stepper, net, dt, 15);
    });
  };
  const auto springs = [](const Net& net) { return spring_network<3>(net.springs) + net.gravity(); };
  const auto damped = [](const Net& net) {
    return spring_network<3>(net.springs, SpringDamping{net.u.of(0.8, 0, 1, -1)}) + net.gravity() +
           LinearDrag{net.u.of(0.1, 0, 1, -1)};
  };
  check(trapezoidal, 0.01, to_rounding, springs);
  check(backward_euler, 0.1, to_rounding, springs);  // with tangents that are indefinite on the way
  check(tr_bdf2, 0.1, to_tolerance, damped);
  check(trapezoidal, 0.05, to_rounding,
        [](const Net& net) { return spring_network<3>(net.springs) + at(forward_euler, net.gravity()); });
}

TEST_CASE("units: a net in steps of its own choice, with events on the way") {
  check_all([](const Units& u) {
    Net net{u};
    PhiStepper stepper{net.y, spring_network<3>(net.springs) + net.gravity() + LinearDrag{u.of(0.2, 0, 1, -1)}, tr_bdf2,
                       mass(net.masses)};
    double seen = 0, sum = 0;
    const auto height = [low = u.of(-1, 1, 0, 0)](const auto& y) { return y.r.row(2).minCoeff() - low; };
    const auto bounce = [&](double t, auto& y) {
      y.v.row(2) = y.v.row(2).cwiseAbs();
      ++seen;
      sum += std::ldexp(t, -u.time);
    };
    const auto report =
        integrate(stepper, net.y, {0.0, u.of(1.5, 0, 0, 1)}, tolerance{.rtol = 1e-3, .norm = Norm::particle},
                  event(height, {.direction = Direction::falling}, bounce));
    Result result{describe(report.outcome), net.numbers(), report.statistics};
    result.numbers.conservativeResize(98);
    CHECK(seen > 0);
    result.numbers.tail<2>() << seen, sum;
    return result;
  });
}

TEST_CASE("units: the energy ledger") {
  check_all([](const Units& u) {
    Net net{u};
    PhiStepper stepper{net.y, spring_network<3>(net.springs, SpringDamping{u.of(0.8, 0, 1, -1)}) + net.gravity(),
                       backward_euler, mass(net.masses), newton({.rtol = 1e-3, .atol = u.of(1e-4, 1, 0, -1)})};
    EnergyLedger ledger{stepper};
    const auto report = integrate(stepper, net.y, {0.0, u.of(1, 0, 0, 1)}, fixed(u.of(0.05, 0, 0, 1)), ledger);
    Vec accounts(6);
    accounts << ledger.energy(), ledger.scheme(), ledger.damping(), ledger.solver(), ledger.closure(),
        ledger.largest_closure();
    for (double& x : accounts) x = std::ldexp(x, -2 * u.length - u.mass + 2 * u.time);
    return Result{describe(report.outcome), accounts, report.statistics};
  });
}
