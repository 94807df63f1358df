#pragma once

// What energy_ledger.test.cpp and its full half share.

#include <phistep/phistep.hpp>
#include <phistep/run/inside/dense_output.hpp>
#include <phistep/run/observers/completed_step.hpp>
#include <phistep/sparse.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "problems/oscillator.hpp"
#include "problems/spring_net.hpp"
#include "support/catch.hpp"

namespace energy_ledger_cases {

using namespace phistep;

using One = Eigen::Matrix<double, 1, 1>;

/// n steps with the ledger as their only observer.
template <class Stepper, class S, class Ledger>
void march(Stepper& stepper, S& y, double h, int n, Ledger& ledger, auto&& edit, double t0 = 0) {
  ledger.begin(t0, y);
  DenseOutput<S> dense;
  for (int k = 0; k < n; ++k) {
    const double t = t0 + k * h;
    edit(k, y);
    const S start = y;
    const auto done = stepper.step(y, t, h);
    if (!done) throw std::runtime_error(done.message());
    const S end = y;
    ledger(CompletedStep<S>{t, h, t0 + (k + 1) * h, start, end, dense});
  }
}
template <class Stepper, class S, class Ledger>
void march(Stepper& stepper, S& y, double h, int n, Ledger& ledger) {
  march(stepper, y, h, n, ledger, [](int, S&) {});
}

inline constexpr double omega_squared = 4;
inline const auto spring = with_energy([](const One& r) -> One { return -omega_squared * r; },
                                       [](const One& r) { return omega_squared * r.squaredNorm() / 2; });
inline const auto pendulum = with_energy([](const One& r) -> One { return One{-9.81 * std::sin(r[0])}; },
                                         [](const One& r) { return 9.81 * (1 - std::cos(r[0])); });

/// The bound on closure: a step's accounts are a few products of the size of E, each rounded; over n steps their errors
/// add up like a walk, and at worst to n times as much.
inline double rounding(int n) { return 8 * 2.2e-16 * std::max(8.0, std::sqrt(n)); }

/// A force f(r, v, t) counts as damping: only a struct can say that it ignores v.
struct Drive : ForceTerm {
  static constexpr bool uses_velocity = false;
  void add(double t, const auto&, auto& out) const { out.force[0] += std::cos(t); }
};
/// A spring whose stiffness may be changed.
struct Tunable : ForceTerm {
  double k = 4;
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto& y, auto& out) const { out.force -= k * y.r; }
  double energy(double, const auto& y) const { return k * y.r.squaredNorm() / 2; }
};
/// Pulls the first particle of a net to and fro.
struct Shaker : ForceTerm {
  static constexpr bool uses_velocity = false;
  static constexpr Structure structure = Structure::none;
  double force, omega;
  Shaker(double f, double w) : force{f}, omega{w} {}
  void add(double t, const auto&, auto& out) const { out.force[0] += force * std::sin(omega * t); }
  void add_jacobian(double, const auto&, auto&) const {}
};

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
template <class Force, class Any, class... More>
Books book(const Force& force, Any scheme, Motion<One>& y, double h, int n, const Editor& edit, const More&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  EnergyLedger ledger{stepper};
  march(stepper, y, h, n, ledger, edit);
  return books(ledger);
}
inline const Editor nobody = [](int, Motion<One>&) {};

// The accounts, one by one: each against the formula of its scene.

struct Undamped {
  static constexpr double h = 0.15;
  static constexpr int n = 200;
  static Motion<One> start() { return {One{1.0}, One{0.5}}; }
};
inline void check_undamped(const Books& b, double phi) {
  const double a_squared = omega_squared * Undamped::h * Undamped::h;
  const int n = Undamped::n;
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
}

/// One step by hand: ΔE is known without a ledger, and undamped nobody else may take it.
inline void check_one_step(const std::function<Books(Motion<One>&)>& step) {
  Motion<One> y{One{1.0}, One{0.5}};
  const double before = 0.5 * y.v[0] * y.v[0] + 0.5 * omega_squared * y.r[0] * y.r[0];
  const Books b = step(y);
  const double changed = 0.5 * y.v[0] * y.v[0] + 0.5 * omega_squared * y.r[0] * y.r[0] - before;
  CHECK(std::abs(changed) > 1e-3);
  CHECK(b.scheme == Approx(changed).epsilon(1e-13));
  CHECK(std::abs(b.solver) <= 1e-15);
  CHECK(std::abs(b.closure) <= 1e-15);
}

/// v = v₀ e^{−ct/m}: the energy lost by t is ½mv₀²(1 − e^{−2ct/m}); every scheme here is of order 2 in h.
struct Dragged {
  static constexpr double c = 0.8, m = 2, v0 = 3;
  static Motion<One> start() { return {One{0.0}, One{v0}}; }
};
inline void check_drag(const Books& b, double h, int n) {
  const double exact =
      -0.5 * Dragged::m * Dragged::v0 * Dragged::v0 * (1 - std::exp(-2 * Dragged::c * n * h / Dragged::m));
  CHECK(b.damping == Approx(exact).epsilon(1e-6));
  CHECK(std::abs(b.scheme) <= 1e-6 * -exact);
  CHECK(b.external == 0);
  CHECK(std::abs(b.closure) <= rounding(n) * b.start);
}
/// The same at φ = 1: v⁺ = v/(1 + x), x = ch/m. Drag takes Δr c v⁺ = hc v⁺², the scheme −½m Δv²: two geometric sums.
inline void check_backward_drag(const Books& b, double h, int n) {
  const double c = Dragged::c, m = Dragged::m, v0 = Dragged::v0, x = c * h / m, q = 1 / ((1 + x) * (1 + x));
  const double sum = v0 * v0 * q * (1 - std::pow(q, n)) / (1 - q);  // Σ v⁺²
  CHECK(b.damping == Approx(-h * c * sum).epsilon(1e-13));
  CHECK(b.scheme == Approx(-0.5 * m * x * x * sum).epsilon(1e-13));
}

void check_moved_potential(auto scheme, const auto&... more) {
  // A spring whose rest point is dragged along at speed u: V = ½k(r − ut)². The hand that drags does ∫−k(r − ut)u dt.
  const double k = 4, u = 0.7, h = 1e-3;
  const int n = 1000;
  const auto force = with_energy([=](const One& r, const One&, double t) -> One { return One{-k * (r[0] - u * t)}; },
                                 [=](const One& r, double t) { return 0.5 * k * (r[0] - u * t) * (r[0] - u * t); });
  Motion<One> y{One{0.0}, One{0.0}};
  PhiStepper stepper{y, force, scheme, more...};
  EnergyLedger ledger{stepper};
  march(stepper, y, h, n, ledger);
  // In the moving frame s = −(u/ω) sin ωt, so that the work is −k u ∫s dt = u²(1 − cos ωt).
  const double omega = std::sqrt(k);
  CHECK(ledger.external() == Approx(u * u * (1 - std::cos(omega * n * h))).epsilon(1e-5));
  CHECK(std::abs(ledger.damping()) <= 1e-14);
  CHECK(std::abs(ledger.scheme()) <= 1e-6 * ledger.largest_energy());
  CHECK(std::abs(ledger.closure()) <= rounding(n) * ledger.largest_energy());
}

/// One linear step whose end is spoiled by hand: ρ and δ are known, and so are all accounts.
struct Spoiled {
  static constexpr double h = 0.25, m = 2;
  static Motion<One> start() { return {One{1.0}, One{0.5}}; }
};
Books spoil(const auto& force, auto scheme, Motion<One>& end, double dr, double dv) {
  const double h = Spoiled::h;
  const Motion<One> start = end = Spoiled::start();
  PhiStepper stepper{end, force, scheme, mass(Spoiled::m)};
  if (!stepper.step(end, 0, h)) throw std::runtime_error("a linear step failed");
  end.r[0] += dr, end.v[0] += dv;
  EnergyLedger ledger{stepper};
  DenseOutput<Motion<One>> dense;
  ledger(CompletedStep<Motion<One>>{0, h, h, start, end, dense});
  return books(ledger);
}
/// @param spoil  the step, its end to be moved by (dr, dv)
inline void check_spoiled(const std::function<Books(Motion<One>& end, double dr, double dv)>& spoil, bool verlet) {
  const double h = Spoiled::h, m = Spoiled::m, k = omega_squared;
  const Motion<One> start = Spoiled::start();
  const auto check = [&](double dr, double dv) {
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
  CHECK(check(0, 0) <= 2e-15);
  CHECK(check(0, 0.01) > 1e-4);
  CHECK(check(0.01, 0) > 1e-4);
}

/// @param drop  a body of mass 3 for 500 steps of 0.01, under its weight
inline void check_bounces(const std::function<Books(Motion<One>&, const Editor&)>& drop) {
  Motion<One> y{One{1.0}, One{0.0}};
  double removed = 0;
  int bounces = 0;
  const Books b = drop(y, [&](int, Motion<One>& s) {
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

void check_mass_matrix(auto scheme, const auto& force, const auto& m) {
  const int n = 300;
  Motion<Eigen::VectorXd> y{Eigen::Vector3d(1, 0, -0.5), Eigen::Vector3d(0, 0.3, 0)};
  PhiStepper stepper{y, force, scheme, mass(m)};
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.1, n, ledger);
  CHECK(std::abs(ledger.closure()) <= rounding(n) * ledger.largest_energy());
  CHECK(std::abs(ledger.solver()) <= 1e-12 * ledger.largest_energy());
  CHECK(ledger.scheme() == Approx(ledger.energy() - ledger.start()).margin(1e-12));
  CHECK(ledger.external() == 0);
}
inline Eigen::MatrixXd coupled_masses() { return Eigen::Matrix3d{{4, 1, 0}, {1, 3, 0.5}, {0, 0.5, 2}}; }
inline Eigen::MatrixXd coupled_springs() { return Eigen::Matrix3d{{-9, 2, 0}, {2, -7, 1}, {0, 1, -5}}; }

/// A run of an oscillator from (1, 0), 4 of stiffness, by the trapezoidal rule.
template <class Stepper>
void check_editing_observer(Stepper& stepper, Motion<One>& y) {
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
/// The same by backward Euler.
template <class Stepper>
void check_second_run(Stepper& stepper, Motion<One>& y) {
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
template <class Stepper>
void check_print(Stepper& stepper, Motion<One>& y) {
  EnergyLedger ledger{stepper};
  march(stepper, y, 0.1, 10, ledger);
  std::ostringstream out;
  out << ledger;
  CHECK_THAT(out.str(), contains("energy over 10 steps") &&
                            contains("at the start          2.00000000e+00       1.0e+00") &&
                            contains("scheme               -") && contains("damping") && contains("external work") &&
                            contains("solver") && contains("edits") && contains("closure"));
}

/// @param calls  that the ledger asks for in 20 steps
template <class Stepper, class State>
void check_onlooker(Stepper one, State alone, int calls) {
  auto watched = alone;
  auto two = one;
  EnergyLedger ledger{two};
  for (int k = 0; k < 20; ++k) REQUIRE(one.step(alone, 0.1 * k, 0.1));
  march(two, watched, 0.1, 20, ledger);
  CHECK(alone.r == watched.r);
  CHECK(alone.v == watched.v);
  CHECK(one.statistics().force_calls == two.statistics().force_calls);
  CHECK(ledger.force_calls() == calls);
}

}  // namespace energy_ledger_cases
