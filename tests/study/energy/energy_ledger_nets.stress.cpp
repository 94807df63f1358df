// energy_ledger, every scheme: nets of springs. In short: energy_ledger.test.cpp.
#include "study/energy/energy_ledger_cases.hpp"

using namespace energy_ledger_cases;

TEMPLATE_TEST_CASE_SIG("a pendulum and a spring net: the scheme's account is all of ΔE, closed to rounding", "",
                       ((int which), which), 0, 1, 2, 3, 4, 5, 6) {
  const auto scheme = [] {
    if constexpr (which == 0) return trapezoidal;
    else if constexpr (which == 1) return backward_euler;
    else if constexpr (which == 2) return phi(0.7);
    else if constexpr (which == 3) return velocity_verlet;
    else if constexpr (which == 4) return symplectic_euler;
    else if constexpr (which == 5) return midpoint;
    else return phi_stage(0.6);
  }();
  const auto check = [&](auto y, const auto& force, const auto& m, double h, int n) {
    PhiStepper stepper{y, force, scheme, m};
    EnergyLedger ledger{stepper};
    march(stepper, y, h, n, ledger);
    const double E = ledger.largest_energy();
    CHECK(std::abs(ledger.closure()) <= rounding(n) * E);
    CHECK(ledger.largest_closure() <= rounding(n) * E);
    CHECK(std::abs(ledger.solver()) <= 1e-12 * E);
    CHECK(ledger.scheme() == Approx(ledger.energy() - ledger.start()).margin(1e-12 * E));
    CHECK(std::abs(ledger.scheme()) > 1e-6 * E);
    CHECK(ledger.force_calls() == (which >= 5 ? n : n + 1));
    if (which == 1 || which == 2 || which == 6) CHECK(ledger.scheme() < 0);
  };
  check(Motion<One>{One{2.0}, One{0.0}}, pendulum, UnitMasses{}, 0.05, 1000);
  check(problems::SpringNet::start(), problems::SpringNet::elastic(), mass(problems::SpringNet::masses()), 0.05, 1000);
}

TEST_CASE("a damped, driven, implicit scene under a loose solver: every account is there, and they close") {
  const int n = 5000;
  const auto check = [&](auto scheme, double rtol, bool dashpots) {
    auto y = problems::SpringNet::start();
    const auto run = [&](const auto& springs) {
      PhiStepper stepper{y, springs + LinearDrag{0.05} + Shaker{2.0, 3.0}, scheme, mass(problems::SpringNet::masses()),
                         newton({.rtol = rtol, .atol = rtol})};
      EnergyLedger ledger{stepper};
      march(stepper, y, 0.05, n, ledger);
      const double E = ledger.largest_energy();
      CHECK(ledger.largest_closure() <= rounding(n) * E);
      CHECK(std::abs(ledger.closure()) <= 1e-10 * E);
      CHECK(ledger.damping() < -0.1 * E);
      CHECK(ledger.external() > 0.1 * E);
      CHECK(std::abs(ledger.solver()) > 1e-9 * E);
      return ledger.solver() / E;
    };
    return dashpots ? run(problems::SpringNet::damped()) : run(problems::SpringNet::elastic());
  };
  for (const bool dashpots : {false, true}) {
    const double loose = check(trapezoidal, 1e-3, dashpots), tight = check(trapezoidal, 1e-6, dashpots);
    CHECK(std::abs(tight) < std::abs(loose) / 10);
    check(backward_euler, 1e-3, dashpots);
    check(midpoint, 1e-3, dashpots);
  }
}

TEST_CASE("a run that chooses its steps, some of them done in halves, closes its books") {
  const auto check = [](auto scheme) {
    auto y = problems::SpringNet::start();
    PhiStepper stepper{y, problems::SpringNet::damped() + Shaker{2.0, 3.0}, scheme,
                       mass(problems::SpringNet::masses())};
    EnergyLedger ledger{stepper};
    int steps = 0, halved = 0;
    const auto report = integrate(stepper, y, {0.0, 10.0}, tolerance{.rtol = 1e-4}, ledger,
                                  [&](const CompletedStep<problems::SpringNet::State>& step) {
                                    ++steps;
                                    halved += step.middle() != nullptr ? 1 : 0;
                                  });
    REQUIRE(report);
    CHECK(ledger.steps() == steps);
    CHECK(ledger.force_calls() >= 2 * (steps + halved));
    if (scheme.order() == 2) CHECK(halved > 0);  // the first step has no past to look back on
    const double E = ledger.largest_energy();
    CHECK(ledger.largest_closure() <= 1e-13 * E);
    CHECK(ledger.damping() < -0.1 * E);
    // A controlled run solves to a share of the error allowed; an account of steps that aren't the scheme's would be
    // wrong by much more, the first step's error alone being 1e-4.
    CHECK(std::abs(ledger.solver()) < 1e-3 * E);
  };
  check(trapezoidal);
  check(backward_euler);
  check(midpoint);
  // Verlet solves for v to rounding, and without a solver's tolerance nobody may take anything but physics and scheme.
  auto y = problems::SpringNet::start();
  PhiStepper stepper{y, problems::SpringNet::elastic(), velocity_verlet, mass(problems::SpringNet::masses())};
  EnergyLedger ledger{stepper};
  REQUIRE(integrate(stepper, y, {0.0, 10.0}, tolerance{.rtol = 1e-3}, ledger));
  CHECK(std::abs(ledger.solver()) <= 1e-12 * ledger.largest_energy());
  CHECK(ledger.largest_closure() <= 1e-13 * ledger.largest_energy());
}
