// The assignment of the φ-method's source, against its closed form: ρC θ' = −B cos(2t) x + ρ a I. The named schemes:
// the full tier.
#include <phistep/phistep.hpp>

#include <cmath>

#include "accuracy/observed_order.hpp"
#include "problems/heated_points.hpp"
#include "problems/march.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"

using problems::HeatedPoints;

namespace {

constexpr double end = 1;

HeatedPoints::State solve(auto scheme, int n) {
  const auto theta = HeatedPoints::start();
  phistep::PhiStepper stepper{theta, HeatedPoints{}, scheme, phistep::capacity(HeatedPoints::rho * HeatedPoints::C)};
  return problems::march(stepper, theta, 0.0, end, n);
}

void check_order(auto scheme, double order, int n) {
  convergence::check_order(
      convergence::errors(
          n, [&](int steps) { return problems::distance(solve(scheme, steps), HeatedPoints::exact(end)); }),
      order);
}

}  // namespace

#if PHISTEP_QUICK

TEST_CASE("assignment: every scheme reaches the closed form, at orders 1 and 2") {
  check_order(phistep::phi(0.0), 1, 100);
  check_order(phistep::phi(0.5), 2, 25);
  check_order(phistep::phi(1), 1, 100);
}

TEST_CASE("assignment: theta at dt, 2 dt and 3 dt is what the solution's expressions say") {
  constexpr double rho = 1000, C = 2, B = 5000, x = 0.8, a = 0.3, I = 4, start = 300, dt = 0.3;
  using One = Eigen::Vector<double, 1>;
  const auto rate = [](const One&, double t) -> One { return One{-B * std::cos(2 * t) * x + rho * a * I}; };
  const auto by = [&](double phi, int steps) {
    One theta{start};
    phistep::PhiStepper stepper{theta, rate, phistep::phi(phi), phistep::capacity(rho * C)};
    return problems::march(stepper, theta, 0.0, steps * dt, steps)[0];
  };
  // A: θ + Δt (φ Ψ(t+Δt) + (1−φ) Ψ(t)); B: of φ = 0 the cosines add up to 1, 1 + cos 2Δt, 1 + cos 2Δt + cos 4Δt.
  const auto cosine = [](int n) { return std::cos(2 * n * dt); };
  for (const double phi : {0.0, 0.5, 1.0}) {
    double cosines = 0;
    for (int n = 1; n <= 3; ++n) {
      cosines += phi * cosine(n) + (1 - phi) * cosine(n - 1);
      CAPTURE(phi, n);
      CHECK(by(phi, n) == Approx(start + dt * (-B * cosines / (rho * C) * x + n * a * I / C)).epsilon(1e-15));
    }
  }
  const double at_3_dt = start + dt * (-B * (1 + cosine(1) + cosine(2)) / (rho * C) * x + 3 * a * I / C);
  CHECK(by(0, 3) == Approx(at_3_dt).epsilon(1e-15));
}

TEST_CASE("assignment: the error is that of the quadrature rule, to its first term") {
  // Sums of h cos(2kh): φ at the end, 1−φ at the start. Error (φ−½) h [g(1) − g(0)] and h²/12 [g'(1) − g'(0)] with
  // g = −B cos(2t) x/(ρC); the next term is O(h) of these.
  constexpr int n = 1000;
  constexpr double h = end / n, scale = HeatedPoints::B / (HeatedPoints::rho * HeatedPoints::C);
  const HeatedPoints::State first = scale * (1 - std::cos(2.0)) * HeatedPoints::points();
  const HeatedPoints::State second = scale * 2 * std::sin(2.0) * HeatedPoints::points();
  const auto error = [](auto scheme) { return (solve(scheme, n) - HeatedPoints::exact(end)).eval(); };
  CHECK(problems::distance(error(phistep::phi(0.0)), -h / 2 * first) <= 0.01 * (h / 2 * first).norm());
  CHECK(problems::distance(error(phistep::phi(1)), h / 2 * first) <= 0.01 * (h / 2 * first).norm());
  CHECK(problems::distance(error(phistep::phi(0.5)), h * h / 12 * second) <= 0.01 * (h * h / 12 * second).norm());
}

TEST_CASE("assignment: over a whole period of the heating only a t/C is left, for every phi") {
  constexpr double period = 3.14159265358979323846;
  const auto theta = HeatedPoints::start();
  for (const double phi : {0.0, 0.25, 0.5, 1.0}) {
    phistep::PhiStepper stepper{theta, HeatedPoints{}, phistep::phi(phi),
                                phistep::capacity(HeatedPoints::rho * HeatedPoints::C)};
    const auto reached = problems::march(stepper, theta, 0.0, period, 64);
    const HeatedPoints::State expected = theta.array() + HeatedPoints::a / HeatedPoints::C * period;
    CHECK(problems::distance(reached, expected) <= 64 * 300 * 2.2e-16);  // one rounding of θ ~ 300 a step
  }
}

#elif PHISTEP_FULL
// The assignment of the φ-method's source, by the named schemes.

TEST_CASE("assignment: every scheme reaches the closed form, at orders 1 and 2") {
  check_order(phistep::forward_euler, 1, 100);
  check_order(phistep::trapezoidal, 2, 25);
  check_order(phistep::backward_euler, 1, 100);
  check_order(phistep::midpoint, 2, 25);
}

TEST_CASE("assignment: the error is that of the quadrature rule, to its first term") {
  // Sums of h cos(2kh): φ at the end, 1−φ at the start. Error (φ−½) h [g(1) − g(0)] and h²/12 [g'(1) − g'(0)] with
  // g = −B cos(2t) x/(ρC); the next term is O(h) of these.
  constexpr int n = 1000;
  constexpr double h = end / n, scale = HeatedPoints::B / (HeatedPoints::rho * HeatedPoints::C);
  const HeatedPoints::State first = scale * (1 - std::cos(2.0)) * HeatedPoints::points();
  const HeatedPoints::State second = scale * 2 * std::sin(2.0) * HeatedPoints::points();
  const auto error = [](auto scheme) { return (solve(scheme, n) - HeatedPoints::exact(end)).eval(); };
  CHECK(problems::distance(error(phistep::forward_euler), -h / 2 * first) <= 0.01 * (h / 2 * first).norm());
  CHECK(problems::distance(error(phistep::backward_euler), h / 2 * first) <= 0.01 * (h / 2 * first).norm());
  CHECK(problems::distance(error(phistep::trapezoidal), h * h / 12 * second) <= 0.01 * (h * h / 12 * second).norm());
}

#endif
