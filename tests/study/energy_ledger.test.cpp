// Every account of the energy ledger against a formula of its own, and all of them together against rounding.
#include "study/energy_ledger_cases.hpp"
#include "support/shared_force.hpp"

using namespace energy_ledger_cases;

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

/// What a ledger says.
struct Books {
  double start, kinetic, potential, energy, largest, damping, external, scheme, solver, edits, closure, largest_closure;
  std::int64_t steps, force_calls;
};
template <class Ledger>
Books books(const Ledger& l) {
  return {l.start(),  l.kinetic(), l.potential(), l.energy(),  l.largest_energy(),  l.damping(), l.external(),
          l.scheme(), l.solver(),  l.edits(),     l.closure(), l.largest_closure(), l.steps(),   l.force_calls()};
}
using Editor = std::function<void(int, Motion<One>&)>;

/// n steps of h from y on.
template <class Force, class Any>
Books booked(
    const Force& force, Any scheme, Motion<One>& y, double m, double h, int n,
    const Editor& edit = [](int, Motion<One>&) {}) {
  PhiStepper stepper{y, force, scheme, mass(m)};
  EnergyLedger ledger{stepper};
  march(stepper, y, h, n, ledger, edit);
  return books(ledger);
}

}  // namespace

TEST_CASE("an undamped oscillator: the scheme takes exactly what the theory says, nobody else takes anything") {
  const double h = 0.15, a_squared = omega_squared * h * h;
  const int n = 200;
  const auto check = [&](const Books& b, double phi) {
    const double start = 0.5 * 0.25 + 0.5 * omega_squared;
    const double ratio = static_cast<double>(std::pow(problems::Oscillator::energy_ratio(a_squared, phi), n));
    INFO("phi = " << phi);
    CHECK(b.start == Approx(start).epsilon(1e-15));
    CHECK(b.scheme / start == Approx(ratio - 1).epsilon(1e-11).margin(1e-13));
    CHECK(b.damping == 0);
    CHECK(b.external == 0);
    CHECK(b.edits == 0);
    CHECK(std::abs(b.solver) <= 1e-13 * b.largest);
    CHECK(std::abs(b.closure) <= rounding(n) * b.largest);
    CHECK(b.largest_closure >= std::abs(b.closure));
  };
  for (const double f : {0.0, 0.3, 0.5, 0.7, 1.0}) {
    Motion<One> y{One{1.0}, One{0.5}};
    check(booked(harmonic, phi(f), y, 1, h, n), f);
  }
  for (const double f : {0.5, 0.7, 1.0}) {
    Motion<One> y{One{1.0}, One{0.5}};
    check(booked(harmonic, phi_stage(f), y, 1, h, n), f);
  }
}

TEST_CASE("the scheme's account of pairs and of Verlet is the change of the oscillator's energy") {
  // One step by hand: ΔE is known without a ledger, and undamped nobody else may take it.
  const auto check = [&](const std::function<Books(Motion<One>&)>& step) {
    Motion<One> y{One{1.0}, One{0.5}};
    const double before = 0.5 * y.v[0] * y.v[0] + 0.5 * omega_squared * y.r[0] * y.r[0];
    const Books b = step(y);
    const double changed = 0.5 * y.v[0] * y.v[0] + 0.5 * omega_squared * y.r[0] * y.r[0] - before;
    CHECK(std::abs(changed) > 1e-3);
    CHECK(b.scheme == Approx(changed).epsilon(1e-13));
    CHECK(std::abs(b.solver) <= 1e-15);
    CHECK(std::abs(b.closure) <= 1e-15);
  };
  check([](Motion<One>& y) { return booked(harmonic, velocity_verlet, y, 1, 0.3, 1); });
  for (const auto& [f, d] : {std::pair{0.0, 1.0}, {1.0, 0.0}, {0.8, 0.4}, {0.25, 1.0}})
    check([f = f, d = d](Motion<One>& y) { return booked(harmonic, phi(f, d), y, 1, 0.3, 1); });
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
  Motion<One> alone{One{2.0}, One{0.0}}, watched = alone;
  PhiStepper one{alone, swinging, phi(0.5), mass(1.0)}, two{watched, swinging, phi(0.5), mass(1.0)};
  EnergyLedger ledger{two};
  for (int k = 0; k < 20; ++k) REQUIRE(one.step(alone, 0.1 * k, 0.1));
  march(two, watched, 0.1, 20, ledger);
  CHECK(alone.r == watched.r);
  CHECK(alone.v == watched.v);
  CHECK(one.statistics().force_calls == two.statistics().force_calls);
  CHECK(ledger.force_calls() == 21);
}

TEST_CASE("drag takes c v² dt: in the limit of small steps the integral of the analytic motion") {
  // v = v₀ e^{−ct/m}: the energy lost by t is ½mv₀²(1 − e^{−2ct/m}); every scheme here is of order 2 in h.
  const double c = 0.8, m = 2, v0 = 3, h = 1e-3;
  const int n = 1000;
  Motion<One> y{One{0.0}, One{v0}};
  const Books b = booked(LinearDrag{c}, phi(0.5), y, m, h, n);
  const double exact = -0.5 * m * v0 * v0 * (1 - std::exp(-2 * c * n * h / m));
  CHECK(b.damping == Approx(exact).epsilon(1e-6));
  CHECK(std::abs(b.scheme) <= 1e-6 * -exact);
  CHECK(b.external == 0);
  CHECK(std::abs(b.closure) <= rounding(n) * b.start);
}

TEST_CASE("backward Euler's own damping is told from the drag's") {
  // The same at φ = 1: v⁺ = v/(1 + x), x = ch/m. Drag takes Δr c v⁺ = hc v⁺², the scheme −½m Δv²: two geometric sums.
  const double c = 0.8, m = 2, v0 = 3, h = 0.1, x = c * h / m, q = 1 / ((1 + x) * (1 + x));
  const int n = 50;
  Motion<One> y{One{0.0}, One{v0}};
  const Books b = booked(LinearDrag{c}, phi(1.0), y, m, h, n);
  const double sum = v0 * v0 * q * (1 - std::pow(q, n)) / (1 - q);  // Σ v⁺²
  CHECK(b.damping == Approx(-h * c * sum).epsilon(1e-13));
  CHECK(b.scheme == Approx(-0.5 * m * x * x * sum).epsilon(1e-13));
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

TEST_CASE("a potential that depends on time does the work ∂V/∂t") {
  // A spring whose rest point is dragged along at speed u: V = ½k(r − ut)². The hand that drags does ∫−k(r − ut)u dt.
  const double k = 4, u = 0.7, h = 1e-3;
  const int n = 1000;
  const auto force = with_energy([=](const One& r, const One&, double t) -> One { return One{-k * (r[0] - u * t)}; },
                                 [=](const One& r, double t) { return 0.5 * k * (r[0] - u * t) * (r[0] - u * t); });
  Motion<One> y{One{0.0}, One{0.0}};
  PhiStepper stepper{y, force, velocity_verlet, mass(1.0)};
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
  const Motion<One> start{One{1.0}, One{0.5}};
  const auto spoiled = [&](auto scheme, Motion<One>& end, double dr, double dv) {
    end = start;
    PhiStepper stepper{end, harmonic, scheme, mass(m)};
    if (!stepper.step(end, 0, h)) throw std::runtime_error("a linear step failed");
    end.r[0] += dr, end.v[0] += dv;
    EnergyLedger ledger{stepper};
    DenseOutput<Motion<One>> dense;
    ledger(CompletedStep<Motion<One>>{0, h, h, start, end, dense});
    return books(ledger);
  };
  using Spoiled = std::function<Books(Motion<One>&, double, double)>;
  const auto check = [&](const Spoiled& spoil, bool verlet, double dr, double dv) {
    Motion<One> end = start;
    const Books b = spoil(end, dr, dv);
    CHECK(std::abs(b.closure) <= 2e-15);
    const double r0 = start.r[0], r1 = end.r[0], v0 = start.v[0], v1 = end.v[0];
    const double force = -k * (r0 + r1) / 2, rho = m * (v1 - v0) - h * force;
    const double delta = r1 - r0 - h * (verlet ? v0 - h / 2 * k * r0 / m : (v0 + v1) / 2);
    const double joins = verlet ? h / 2 * rho * force / m : 0;
    CHECK(b.solver == Approx((v0 + v1) / 2 * rho - delta * force + joins).margin(2e-15));
    CHECK(b.scheme == Approx(verlet ? h * h / 4 * -k * (r1 - r0) * force / m : 0).margin(2e-15));
    return std::abs(b.solver);
  };
  const auto each = [&](const Spoiled& spoil, bool verlet) {
    CHECK(check(spoil, verlet, 0, 0) <= 2e-15);
    CHECK(check(spoil, verlet, 0, 0.01) > 1e-4);
    CHECK(check(spoil, verlet, 0.01, 0) > 1e-4);
  };
  each([&](Motion<One>& end, double dr, double dv) { return spoiled(phi(0.5), end, dr, dv); }, false);
  each([&](Motion<One>& end, double dr, double dv) { return spoiled(phi_stage(0.5), end, dr, dv); }, false);
  each([&](Motion<One>& end, double dr, double dv) { return spoiled(velocity_verlet, end, dr, dv); }, true);
}

TEST_CASE("edits between steps have an account of their own: bounces, and a thermostat") {
  Motion<One> y{One{1.0}, One{0.0}};
  const double weight = 3 * 9.81;
  const auto gravity =
      potential([=](const One&) -> One { return One{-weight}; }, [=](const One& r) { return weight * r[0]; });
  double removed = 0;
  int bounces = 0;
  const Books b = booked(gravity, velocity_verlet, y, 3, 0.01, 500, [&](int, Motion<One>& s) {
    if (s.r[0] > 0 || s.v[0] > 0) return;
    const double before = s.v[0];
    s.v[0] *= -0.8;
    removed += 1.5 * (s.v[0] * s.v[0] - before * before);
    ++bounces;
  });
  CHECK(bounces > 3);
  CHECK(b.edits == Approx(removed).epsilon(1e-12));
  CHECK(std::abs(b.scheme) <= 1e-13 * b.start);  // a constant force: Verlet is exact
  CHECK(std::abs(b.closure) <= rounding(500) * b.start);
  CHECK(b.force_calls == 501 + bounces);
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
  const int n = 300;
  Eigen::MatrixXd M(3, 3), K(3, 3);
  M << 4, 1, 0, 1, 3, 0.5, 0, 0.5, 2;
  K << -9, 2, 0, 2, -7, 1, 0, 1, -5;
  Motion<Eigen::VectorXd> y{Eigen::Vector3d(1, 0, -0.5), Eigen::Vector3d(0, 0.3, 0)};
  PhiStepper stepper{y, linear(K), velocity_verlet, mass(M)};
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.1, n, ledger);
  CHECK(std::abs(ledger.closure()) <= rounding(n) * ledger.largest_energy());
  CHECK(std::abs(ledger.solver()) <= 1e-12 * ledger.largest_energy());
  CHECK(ledger.scheme() == Approx(ledger.energy() - ledger.start()).margin(1e-12));
  CHECK(ledger.external() == 0);
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
  EnergyLedger ledger{stepper};
  double added = 0;
  int shown = 0;
  const auto thermostat = [&](double, Motion<One>& s) {
    if (++shown % 10 != 0) return;
    const double before = s.v[0] * s.v[0] / 2;
    s.v[0] *= 1.1;
    added += s.v[0] * s.v[0] / 2 - before;
  };
  REQUIRE(integrate(stepper, y, {0.0, 10.05}, fixed(0.1), ledger, thermostat));  // the last step is shorter
  CHECK(ledger.steps() == 101);
  CHECK(ledger.edits() == Approx(added).epsilon(1e-13));
  CHECK(std::abs(ledger.scheme()) <= 1e-14);
  CHECK(std::abs(ledger.closure()) <= 1e-14);
  CHECK(stepper.statistics().steps == 101);
}

TEST_CASE("1e5 steps close to 1e-10 of E") {
  Motion<One> y{One{2.0}, One{0.0}};
  const Books b = booked(swinging, velocity_verlet, y, 1, 0.01, 100000);
  CHECK(b.largest_closure <= 1e-10 * b.start);
}

TEST_CASE("a second run starts with new books") {
  Motion<One> y{One{1.0}, One{0.0}};
  PhiStepper stepper{y, harmonic, phi(1.0), mass(1.0)};
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
  PhiStepper stepper{y, harmonic, phi(1.0), mass(1.0)};
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.1, 10, ledger);
  std::ostringstream out;
  out << ledger;
  CHECK_THAT(out.str(), contains("energy over 10 steps") &&
                            contains("at the start          2.00000000e+00       1.0e+00") &&
                            contains("scheme               -") && contains("damping") && contains("external work") &&
                            contains("solver") && contains("edits") && contains("closure"));
}
