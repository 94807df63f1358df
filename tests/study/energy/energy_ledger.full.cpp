// energy_ledger, every scheme: its accounts, one by one. The quick half is energy_ledger.test.cpp.
#include "study/energy/energy_ledger_cases.hpp"

using namespace energy_ledger_cases;

TEST_CASE("an undamped oscillator: the scheme takes exactly what the theory says, nobody else takes anything") {
  const auto check = [](auto scheme, double phi) {
    auto y = Undamped::start();
    check_undamped(book(spring, scheme, y, Undamped::h, Undamped::n, nobody), phi);
  };
  check(forward_euler, 0);
  check(phi(0.3), 0.3);
  check(trapezoidal, 0.5);
  check(phi(0.7), 0.7);
  check(backward_euler, 1);
  check(midpoint, 0.5);
  check(phi_stage(0.7), 0.7);
  check(phi_stage(1), 1);
}

TEST_CASE("the scheme's account of pairs and of Verlet is the change of the oscillator's energy") {
  const auto check = [](auto scheme) {
    check_one_step([scheme](Motion<One>& y) { return book(spring, scheme, y, 0.3, 1, nobody); });
  };
  check(velocity_verlet);
  check(symplectic_euler);
  check(symplectic_euler_adjoint);
  check(phi(0.8, 0.4));
  check(phi(0.25, 1));
}

TEST_CASE("a registered ledger changes neither the steps nor their counts") {
  const auto y = problems::SpringNet::start();
  PhiStepper stepper{y, problems::SpringNet::damped(), trapezoidal, mass(problems::SpringNet::masses())};
  check_onlooker(stepper, y, 2 * 21);  // springs with dashpots: as they are, and at v = 0
}

TEST_CASE("drag takes c v² dt: in the limit of small steps the integral of the analytic motion") {
  const double h = 1e-3;
  const int n = 1000;
  const auto check = [&](auto scheme) {
    auto y = Dragged::start();
    check_drag(book(LinearDrag{Dragged::c}, scheme, y, h, n, nobody, mass(Dragged::m)), h, n);
  };
  check(trapezoidal);
  check(midpoint);
  check(velocity_verlet);
}

TEST_CASE("backward Euler's own damping is told from the drag's") {
  const double h = 0.1;
  const int n = 50;
  auto y = Dragged::start();
  check_backward_drag(book(LinearDrag{Dragged::c}, backward_euler, y, h, n, nobody, mass(Dragged::m)), h, n);
}

TEST_CASE("a driving force does work F·Δr, whatever moves the particle") {
  // F = cos t on a free particle of mass m at rest: v = sin t/m, r = (1 − cos t)/m, work ∫F v dt = sin²t/(2m) = ΔT.
  const double m = 2, h = 1e-3;
  const int n = 1000;
  Motion<One> y{One{0.0}, One{0.0}};
  const auto drive = [](const One&, const One&, double t) -> One { return One{std::cos(t)}; };
  {
    PhiStepper stepper{y, Drive{}, trapezoidal, mass(m)};
    EnergyLedger ledger{stepper};
    march(stepper, y, h, n, ledger);
    CHECK(ledger.external() == Approx(std::pow(std::sin(1.0), 2) / (2 * m)).epsilon(1e-6));
    CHECK(ledger.damping() == 0);
    CHECK(std::abs(ledger.closure()) <= 1e-15);
  }
  {
    y = {One{0.0}, One{0.0}};
    PhiStepper stepper{y, drive, trapezoidal, mass(m)};
    EnergyLedger ledger{stepper};
    march(stepper, y, h, n, ledger);
    CHECK(ledger.damping() == Approx(std::pow(std::sin(1.0), 2) / (2 * m)).epsilon(1e-6));
    CHECK(ledger.external() == 0);
  }
}

TEST_CASE("a potential that depends on time does the work ∂V/∂t") { check_moved_potential(trapezoidal); }

TEST_CASE("the solver's account is the work of what it left unsolved") {
  const auto each = [](auto scheme, bool verlet) {
    check_spoiled([scheme](Motion<One>& end, double dr, double dv) { return spoil(spring, scheme, end, dr, dv); },
                  verlet);
  };
  each(trapezoidal, false);
  each(midpoint, false);
  each(velocity_verlet, true);
}

TEST_CASE("edits between steps have an account of their own: bounces, and a thermostat") {
  check_bounces([](Motion<One>& y, const Editor& edit) {
    return book(Gravity{One{-9.81}}, velocity_verlet, y, 0.01, 500, edit, mass(3.0));
  });
}

TEST_CASE("a change of the force's parameters is an edit, if the ledger is told") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, Tunable{}, trapezoidal};
  EnergyLedger ledger{stepper};
  double added = 0;
  march(stepper, y, 0.1, 20, ledger, [&](int k, auto& s) {
    if (k != 7) return;
    stepper.force().k = 5;
    ledger.forget();
    added = 0.5 * s.r[0] * s.r[0];
  });
  CHECK(ledger.edits() == Approx(added).epsilon(1e-14));
  CHECK(std::abs(ledger.closure()) <= 1e-14);
  CHECK(std::abs(ledger.scheme()) <= 1e-14);
}

TEST_CASE("1e5 steps close to 1e-10 of E") {
  Motion<One> y{One{2.0}, One{0.0}};
  PhiStepper stepper{y, pendulum, velocity_verlet};
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.01, 100000, ledger);
  CHECK(ledger.largest_closure() <= 1e-10 * ledger.start());
}

TEST_CASE("a second run starts with new books") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, spring, backward_euler};
  check_second_run(stepper, y);
}

TEST_CASE("the books in print") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, spring, backward_euler};
  check_print(stepper, y);
}
