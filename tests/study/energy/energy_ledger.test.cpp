// Every account of the energy ledger against a formula of its own, and all of them together against rounding.
#include "study/energy/energy_ledger_cases.hpp"
#if PHISTEP_FULL
#include "support/shared_force.hpp"
#endif

using namespace energy_ledger_cases;

#if PHISTEP_FULL

namespace {

/// All forces of a potential are one type, and so are all φ: phi(½) is trapezoidal, phi(0, 1) symplectic Euler.
using Potential = decltype(with_energy(shared_force::OfState<One>{}, std::function<double(const One&)>{}));
Potential potential(shared_force::OfState<One> force, std::function<double(const One&)> energy) {
  return with_energy(std::move(force), std::move(energy));
}
const Potential harmonic = potential([](const One& r) -> One { return -omega_squared * r; },
                                     [](const One& r) { return omega_squared * r.squaredNorm() / 2; });
const Potential swinging = potential([](const One& r) -> One { return One{-9.81 * std::sin(r[0])}; },
                                     [](const One& r) { return 9.81 * (1 - std::cos(r[0])); });

/// n steps of h from y on.
template <class Force, class Any>
Books booked(const Force& force, Any scheme, Motion<One>& y, double m, double h, int n, const Editor& edit = nobody) {
  return book(force, scheme, y, h, n, edit, mass(m));
}

}  // namespace

TEST_CASE("an undamped oscillator: the scheme takes exactly what the theory says, nobody else takes anything") {
  const auto check = [](auto scheme, double phi) {
    auto y = Undamped::start();
    check_undamped(booked(harmonic, scheme, y, 1, Undamped::h, Undamped::n), phi);
  };
  for (const double f : {0.0, 0.3, 0.5, 0.7, 1.0}) check(phi(f), f);
  for (const double f : {0.5, 0.7, 1.0}) check(phi_stage(f), f);
}

TEST_CASE("the scheme's account of pairs and of Verlet is the change of the oscillator's energy") {
  check_one_step([](Motion<One>& y) { return booked(harmonic, velocity_verlet, y, 1, 0.3, 1); });
  for (const auto& [f, d] : {std::pair{0.0, 1.0}, {1.0, 0.0}, {0.8, 0.4}, {0.25, 1.0}})
    check_one_step([f = f, d = d](Motion<One>& y) { return booked(harmonic, phi(f, d), y, 1, 0.3, 1); });
}

TEMPLATE_TEST_CASE_SIG("a pendulum and a spring net: the scheme's account is all of ΔE, closed to rounding", "",
                       ((int which), which), 0) {
  const int n = 1000;
  const auto check = [&](const Books& b, std::int64_t calls, bool loses) {
    CHECK(std::abs(b.closure) <= rounding(n) * b.largest);
    CHECK(b.largest_closure <= rounding(n) * b.largest);
    CHECK(std::abs(b.solver) <= 1e-12 * b.largest);
    CHECK(b.scheme == Approx(b.energy - b.start).margin(1e-12 * b.largest));
    CHECK(std::abs(b.scheme) > 1e-6 * b.largest);
    CHECK(b.force_calls == calls);
    if (loses) CHECK(b.scheme < 0);
  };
  const Motion<One> start{One{2.0}, One{0.0}};
  auto y = start;
  for (const double f : {0.5, 0.7, 1.0}) y = start, check(booked(swinging, phi(f), y, 1, 0.05, n), n + 1, f > 0.5);
  for (const double f : {0.5, 0.6}) y = start, check(booked(swinging, phi_stage(f), y, 1, 0.05, n), n, f > 0.5);
  y = start, check(booked(swinging, velocity_verlet, y, 1, 0.05, n), n + 1, false);
  y = start, check(booked(swinging, phi(0.0, 1.0), y, 1, 0.05, n), n + 1, false);
}

TEST_CASE("a registered ledger changes neither the steps nor their counts") {
  const Motion<One> y{One{2.0}, One{0.0}};
  check_onlooker(PhiStepper{y, swinging, phi(0.5), mass(1.0)}, y, 21);
}

TEST_CASE("drag takes c v² dt: in the limit of small steps the integral of the analytic motion") {
  const double h = 1e-3;
  const int n = 1000;
  auto y = Dragged::start();
  check_drag(booked(LinearDrag{Dragged::c}, phi(0.5), y, Dragged::m, h, n), h, n);
}

TEST_CASE("backward Euler's own damping is told from the drag's") {
  const double h = 0.1;
  const int n = 50;
  auto y = Dragged::start();
  check_backward_drag(booked(LinearDrag{Dragged::c}, phi(1.0), y, Dragged::m, h, n), h, n);
}

TEST_CASE("a driving force does work F·Δr, whatever moves the particle") {
  // F = cos t on a free particle of mass m at rest: v = sin t/m, r = (1 − cos t)/m, work ∫F v dt = sin²t/(2m) = ΔT.
  const double m = 2;
  Motion<One> y{One{0.0}, One{0.0}};
  const Books b = booked(Drive{}, phi(0.5), y, m, 1e-3, 1000);
  CHECK(b.external == Approx(std::pow(std::sin(1.0), 2) / (2 * m)).epsilon(1e-6));
  CHECK(b.damping == 0);
  CHECK(std::abs(b.closure) <= 1e-15);
}

TEST_CASE("a potential that depends on time does the work ∂V/∂t") { check_moved_potential(velocity_verlet, mass(1.0)); }

TEST_CASE("the solver's account is the work of what it left unsolved") {
  const auto each = [](auto scheme, bool verlet) {
    check_spoiled([scheme](Motion<One>& end, double dr, double dv) { return spoil(harmonic, scheme, end, dr, dv); },
                  verlet);
  };
  each(phi(0.5), false);
  each(phi_stage(0.5), false);
  each(velocity_verlet, true);
}

TEST_CASE("edits between steps have an account of their own: bounces, and a thermostat") {
  const double weight = 3 * 9.81;
  const auto gravity =
      potential([=](const One&) -> One { return One{-weight}; }, [=](const One& r) { return weight * r[0]; });
  check_bounces(
      [&](Motion<One>& y, const Editor& edit) { return booked(gravity, velocity_verlet, y, 3, 0.01, 500, edit); });
}

TEST_CASE("a change of the force's parameters is an edit, if the ledger is told") {
  Motion<One> y{One{1.0}, One{0.0}};
  double k = 4, added = 0;
  PhiStepper stepper{
      y,
      potential([&k](const One& r) -> One { return -k * r; }, [&k](const One& r) { return k * r.squaredNorm() / 2; }),
      phi(0.5), mass(1.0)};
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.1, 20, ledger, Editor{[&](int n, Motion<One>& s) {
          if (n != 7) return;
          static_cast<void>(stepper.force());  // who is handed the force may change it: the stepper asks anew
          k = 5;
          stepper.reset();
          ledger.forget();
          added = 0.5 * s.r[0] * s.r[0];
        }});
  CHECK(ledger.edits() == Approx(added).epsilon(1e-14));
  CHECK(std::abs(ledger.closure()) <= 1e-14);
  CHECK(std::abs(ledger.scheme()) <= 1e-14);
}

TEST_CASE("masses that are matrices, 3xN states, maps, float and long double") {
  check_mass_matrix(velocity_verlet, linear(coupled_springs()), coupled_masses());
}

TEST_CASE("a matrix K that is not symmetric has no potential: its work is external") {
  Eigen::MatrixXd K(2, 2), M = Eigen::MatrixXd::Identity(2, 2);
  K << -4, 1, -1, -4;
  Motion<Eigen::VectorXd> y{Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 0)};
  PhiStepper stepper{y, linear(K), velocity_verlet, mass(M)};
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.1, 100, ledger);
  CHECK(ledger.potential() == 0);
  CHECK(std::abs(ledger.external()) > 0.1);
  CHECK(std::abs(ledger.closure()) <= rounding(100) * ledger.largest_energy());
}

TEST_CASE("a run that chooses its steps, some of them done in halves, closes its books") {
  Motion<One> y{One{2.0}, One{0.0}};
  PhiStepper stepper{y, swinging, phi(0.5), mass(1.0)};
  EnergyLedger ledger{stepper};
  int steps = 0, halved = 0;
  const auto report =
      integrate(stepper, y, {0.0, 10.0}, tolerance{.rtol = 1e-4}, ledger, [&](const CompletedStep<Motion<One>>& step) {
        ++steps;
        halved += step.middle() != nullptr ? 1 : 0;
      });
  REQUIRE(report);
  CHECK(ledger.steps() == steps);
  CHECK(ledger.force_calls() >= steps + halved);
  CHECK(halved > 0);  // the first step has no past to look back on
  const double E = ledger.largest_energy();
  CHECK(ledger.largest_closure() <= 1e-13 * E);
  // A controlled run solves to a share of the error allowed; an account of steps that aren't the scheme's would be
  // wrong by much more, the first step's error alone being 1e-4.
  CHECK(std::abs(ledger.solver()) < 1e-3 * E);
}

TEST_CASE("a run of fixed steps with an observer that edits: what it does counts as edits") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, harmonic, phi(0.5), mass(1.0)};
  check_editing_observer(stepper, y);
}

TEST_CASE("1e5 steps close to 1e-10 of E") {
  Motion<One> y{One{2.0}, One{0.0}};
  const Books b = booked(swinging, velocity_verlet, y, 1, 0.01, 100000);
  CHECK(b.largest_closure <= 1e-10 * b.start);
}

TEST_CASE("a second run starts with new books") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, harmonic, phi(1.0), mass(1.0)};
  check_second_run(stepper, y);
}

TEST_CASE("the books in print") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, harmonic, phi(1.0), mass(1.0)};
  check_print(stepper, y);
}

#elif PHISTEP_STRESS
// energy_ledger, every scheme: its accounts, one by one.

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

#endif
