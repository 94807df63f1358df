// energy_ledger, every scheme: its accounts, one by one. The quick half is energy_ledger.test.cpp.
#include "study/energy_ledger_cases.hpp"

using namespace energy_ledger_cases;

TEST_CASE("an undamped oscillator: the scheme takes exactly what the theory says, nobody else takes anything") {
  const double h = 0.15, a_squared = omega_squared * h * h;
  const int n = 200;
  const auto check = [&](auto scheme, double phi) {
    Motion<One> y{One{1.0}, One{0.5}};
    PhiStepper stepper{y, spring, scheme};
    EnergyLedger ledger{stepper};
    march(stepper, y, h, n, ledger);
    const double start = 0.5 * 0.25 + 0.5 * omega_squared;
    const double ratio = static_cast<double>(std::pow(problems::Oscillator::energy_ratio(a_squared, phi), n));
    INFO("phi = " << phi);
    CHECK(ledger.start() == Approx(start).epsilon(1e-15));
    CHECK(ledger.scheme() / start == Approx(ratio - 1).epsilon(1e-11).margin(1e-13));
    CHECK(ledger.damping() == 0);
    CHECK(ledger.external() == 0);
    CHECK(ledger.edits() == 0);
    CHECK(std::abs(ledger.solver()) <= 1e-13 * ledger.largest_energy());
    CHECK(std::abs(ledger.closure()) <= rounding(n) * ledger.largest_energy());
    CHECK(ledger.largest_closure() >= std::abs(ledger.closure()));
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
  // One step by hand: ΔE is known without a ledger, and undamped nobody else may take it.
  const double h = 0.3;
  const auto check = [&](auto scheme) {
    Motion<One> y{One{1.0}, One{0.5}};
    PhiStepper stepper{y, spring, scheme};
    EnergyLedger ledger{stepper};
    double before = 0.5 * y.v[0] * y.v[0] + 0.5 * omega_squared * y.r[0] * y.r[0], changed = 0;
    march(stepper, y, h, 1, ledger);
    changed = 0.5 * y.v[0] * y.v[0] + 0.5 * omega_squared * y.r[0] * y.r[0] - before;
    CHECK(std::abs(changed) > 1e-3);
    CHECK(ledger.scheme() == Approx(changed).epsilon(1e-13));
    CHECK(std::abs(ledger.solver()) <= 1e-15);
    CHECK(std::abs(ledger.closure()) <= 1e-15);
  };
  check(velocity_verlet);
  check(symplectic_euler);
  check(symplectic_euler_adjoint);
  check(phi(0.8, 0.4));
  check(phi(0.25, 1));
}

TEST_CASE("a registered ledger changes neither the steps nor their counts") {
  auto alone = problems::SpringNet::start(), watched = alone;
  PhiStepper one{alone, problems::SpringNet::damped(), trapezoidal, mass(problems::SpringNet::masses())};
  PhiStepper two{watched, problems::SpringNet::damped(), trapezoidal, mass(problems::SpringNet::masses())};
  EnergyLedger ledger{two};
  for (int k = 0; k < 20; ++k) REQUIRE(one.step(alone, 0.1 * k, 0.1));
  march(two, watched, 0.1, 20, ledger);
  CHECK(alone.r == watched.r);
  CHECK(alone.v == watched.v);
  CHECK(one.statistics().force_calls == two.statistics().force_calls);
  CHECK(ledger.force_calls() == 2 * 21);  // springs with dashpots: as they are, and at v = 0
}

TEST_CASE("drag takes c v² dt: in the limit of small steps the integral of the analytic motion") {
  // v = v₀ e^{−ct/m}: the energy lost by t is ½mv₀²(1 − e^{−2ct/m}); every scheme here is of order 2 in h.
  const double c = 0.8, m = 2, v0 = 3, h = 1e-3;
  const int n = 1000;
  const auto check = [&](auto scheme) {
    Motion<One> y{One{0.0}, One{v0}};
    PhiStepper stepper{y, LinearDrag{c}, scheme, mass(m)};
    EnergyLedger ledger{stepper};
    march(stepper, y, h, n, ledger);
    const double exact = -0.5 * m * v0 * v0 * (1 - std::exp(-2 * c * n * h / m));
    CHECK(ledger.damping() == Approx(exact).epsilon(1e-6));
    CHECK(std::abs(ledger.scheme()) <= 1e-6 * -exact);
    CHECK(ledger.external() == 0);
    CHECK(std::abs(ledger.closure()) <= rounding(n) * ledger.start());
  };
  check(trapezoidal);
  check(midpoint);
  check(velocity_verlet);
}

TEST_CASE("backward Euler's own damping is told from the drag's") {
  // The same at φ = 1: v⁺ = v/(1 + x), x = ch/m. Drag takes Δr c v⁺ = hc v⁺², the scheme −½m Δv²: two geometric sums.
  const double c = 0.8, m = 2, v0 = 3, h = 0.1, x = c * h / m, q = 1 / ((1 + x) * (1 + x));
  const int n = 50;
  Motion<One> y{One{0.0}, One{v0}};
  PhiStepper stepper{y, LinearDrag{c}, backward_euler, mass(m)};
  EnergyLedger ledger{stepper};
  march(stepper, y, h, n, ledger);
  const double sum = v0 * v0 * q * (1 - std::pow(q, n)) / (1 - q);  // Σ v⁺²
  CHECK(ledger.damping() == Approx(-h * c * sum).epsilon(1e-13));
  CHECK(ledger.scheme() == Approx(-0.5 * m * x * x * sum).epsilon(1e-13));
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

TEST_CASE("a potential that depends on time does the work ∂V/∂t") {
  // A spring whose rest point is dragged along at speed u: V = ½k(r − ut)². The hand that drags does ∫−k(r − ut)u dt.
  const double k = 4, u = 0.7, h = 1e-3;
  const int n = 1000;
  const auto force = with_energy([=](const One& r, const One&, double t) -> One { return One{-k * (r[0] - u * t)}; },
                                 [=](const One& r, double t) { return 0.5 * k * (r[0] - u * t) * (r[0] - u * t); });
  Motion<One> y{One{0.0}, One{0.0}};
  PhiStepper stepper{y, force, trapezoidal};
  EnergyLedger ledger{stepper};
  march(stepper, y, h, n, ledger);
  // In the moving frame s = −(u/ω) sin ωt, so that the work is −k u ∫s dt = u²(1 − cos ωt).
  const double omega = std::sqrt(k);
  CHECK(ledger.external() == Approx(u * u * (1 - std::cos(omega * n * h))).epsilon(1e-5));
  CHECK(std::abs(ledger.damping()) <= 1e-14);
  CHECK(std::abs(ledger.scheme()) <= 1e-6 * ledger.largest_energy());
  CHECK(std::abs(ledger.closure()) <= rounding(n) * ledger.largest_energy());
}

TEST_CASE("the solver's account is the work of what it left unsolved") {
  // One linear step whose end is spoiled by hand: ρ and δ are known, and so are all accounts.
  const double h = 0.25, m = 2, k = omega_squared;
  const auto check = [&](auto scheme, double dr, double dv) {
    const Motion<One> start{One{1.0}, One{0.5}};
    Motion<One> end = start;
    PhiStepper stepper{end, spring, scheme, mass(m)};
    REQUIRE(stepper.step(end, 0, h));
    end.r[0] += dr, end.v[0] += dv;
    EnergyLedger ledger{stepper};
    DenseOutput<Motion<One>> dense;
    ledger(CompletedStep<Motion<One>>{0, h, h, start, end, dense});
    CHECK(std::abs(ledger.closure()) <= 2e-15);

    constexpr bool verlet = std::is_same_v<decltype(scheme), VelocityVerlet>;
    const double r0 = start.r[0], r1 = end.r[0], v0 = start.v[0], v1 = end.v[0];
    const double force = -k * (r0 + r1) / 2, rho = m * (v1 - v0) - h * force;
    const double delta = r1 - r0 - h * (verlet ? v0 - h / 2 * k * r0 / m : (v0 + v1) / 2);
    const double joins = verlet ? h / 2 * rho * force / m : 0;
    CHECK(ledger.solver() == Approx((v0 + v1) / 2 * rho - delta * force + joins).margin(2e-15));
    CHECK(ledger.scheme() == Approx(verlet ? h * h / 4 * -k * (r1 - r0) * force / m : 0).margin(2e-15));
    return std::abs(ledger.solver());
  };
  const auto each = [&](auto scheme) {
    CHECK(check(scheme, 0, 0) <= 2e-15);
    CHECK(check(scheme, 0, 0.01) > 1e-4);
    CHECK(check(scheme, 0.01, 0) > 1e-4);
  };
  each(trapezoidal);
  each(midpoint);
  each(velocity_verlet);
}

TEST_CASE("edits between steps have an account of their own: bounces, and a thermostat") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, Gravity{Eigen::Matrix<double, 1, 1>{-9.81}}, velocity_verlet, mass(3.0)};
  EnergyLedger ledger{stepper};
  double removed = 0;
  int bounces = 0;
  march(stepper, y, 0.01, 500, ledger, [&](int, auto& s) {
    if (s.r[0] > 0 || s.v[0] > 0) return;
    const double before = s.v[0];
    s.v[0] *= -0.8;
    removed += 1.5 * (s.v[0] * s.v[0] - before * before);
    ++bounces;
  });
  CHECK(bounces > 3);
  CHECK(ledger.edits() == Approx(removed).epsilon(1e-12));
  CHECK(std::abs(ledger.scheme()) <= 1e-13 * ledger.start());  // a constant force: Verlet is exact
  CHECK(std::abs(ledger.closure()) <= rounding(500) * ledger.start());
  CHECK(ledger.force_calls() == 501 + bounces);
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
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.1, 10, ledger);
  const double first = ledger.scheme();
  y = {One{1.0}, One{0.0}};
  march(stepper, y, 0.1, 10, ledger);
  CHECK(ledger.scheme() == first);
  CHECK(ledger.edits() == 0);
  CHECK(ledger.steps() == 10);
  CHECK(ledger.force_calls() == 11);
}

TEST_CASE("the books in print") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, spring, backward_euler};
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.1, 10, ledger);
  std::ostringstream out;
  out << ledger;
  CHECK_THAT(out.str(), contains("energy over 10 steps") &&
                            contains("at the start          2.00000000e+00       1.0e+00") &&
                            contains("scheme               -") && contains("damping") && contains("external work") &&
                            contains("solver") && contains("edits") && contains("closure"));
}
