// Fixed-point iteration: contraction by exactly φ²a² on an oscillator, convergence up to a = 1/φ and not beyond. Beside
// Newton, and of many unknowns: fixed_point.full.cpp.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <complex>

#include "problems/oscillator.hpp"
#include "support/catch.hpp"

using namespace phistep;
using problems::Oscillator;

namespace {

Oscillator::State start() { return {Oscillator::Vector(1.0), Oscillator::Vector(0.3)}; }

/// The history of a solve cut short after `iterations`.
Failure cut_short(double a, auto scheme, int iterations) {
  Oscillator::State y = start();
  PhiStepper stepper{y, Oscillator{a * a}, scheme, fixed_point({.max_iterations = iterations, .depth = 0})};
  const StepReport report = stepper.step(y, 0, 1);
  REQUIRE_FALSE(report);
  return report.failure();
}

}  // namespace

TEST_CASE("plain iteration contracts by phi^2 a^2 on an oscillator") {
  for (const double p : {0.5, 0.7, 1.0})
    for (const double c : {0.5, 0.7, 0.9}) {  // a = c/φ: contraction c²
      const double a = c / p, expected = c * c;
      const Failure f = cut_short(a, phi(p), 20);
      CAPTURE(p, a, f.message());
      CHECK(f.outcome == Outcome::iteration_stalled);
      REQUIRE(f.iterations == 20);
      // Every one of them, while the increment stands above the rounding of its parts: 1e-14 leaves 1 % at 1e-12.
      for (std::size_t k = 1; k < 20 && f.increments[k] > 1e-12; ++k)
        CHECK(std::abs(f.increments[k] / f.increments[k - 1] / expected - 1) < 0.01);
    }
}

TEST_CASE("plain iteration converges for a < 1/phi, diverges beyond, and says so early") {
  for (const double p : {0.5, 0.7, 1.0}) {
    Oscillator::State y = start(), z = start();
    const double inside = 0.97 / p, outside = 1.03 / p;
    // 0.97² a time: 36.04/0.0609 = 592 iterations to 2.2e-16
    PhiStepper a{y, Oscillator{inside * inside}, phi(p), fixed_point({.max_iterations = 700, .depth = 0})};
    const StepReport converged = a.step(y, 0, 1);
    CAPTURE(p, converged.message());
    CHECK(converged);
    PhiStepper newton_stepper{z, Oscillator{inside * inside}, phi(p)};
    REQUIRE(newton_stepper.step(z, 0, 1));
    // The noise of the iteration itself is amplified by 1/(1 − φ²a²) = 17.
    CHECK(std::abs(y.r[0] - z.r[0]) <= 40 * 2.3e-16 * (std::abs(z.r[0]) + std::abs(z.v[0])));
    CHECK(std::abs(y.v[0] - z.v[0]) <= 40 * 2.3e-16 * (std::abs(z.r[0]) + std::abs(z.v[0])) / p);

    Oscillator::State u = start();
    PhiStepper b{u, Oscillator{outside * outside}, phi(p), fixed_point({.depth = 0})};
    const StepReport report = b.step(u, 0, 1);
    CAPTURE(report.message());
    CHECK(report.outcome() == Outcome::iteration_diverged);
    CHECK(report.iterations() <= 8);
    CHECK_THAT(report.message(), contains("fixed-point iteration diverged") && contains("newton()"));
    CHECK((u.r[0] == 1 && u.v[0] == 0.3));
  }
}

TEST_CASE("no Jacobian, no matrix, no solve: one force call an iteration") {
  Oscillator::State y = start();
  PhiStepper stepper{y, Oscillator{1.0}, backward_euler, fixed_point()};
  for (int k = 0; k < 10; ++k) REQUIRE(stepper.step(y, 0, 0.3));
  const Statistics& s = stepper.statistics();
  CHECK(s.jacobians + s.factorizations + s.solves == 0);
  CHECK(s.force_calls == s.iterations);
}

TEST_CASE("acceleration begins each solve anew: as many iterations and the same bits as a fresh stepper's") {
  using Vector = Eigen::Vector4d;
  const auto chain = [](const Vector& x) -> Vector {
    return {x[1] - 2 * x[0], x[0] - 3 * x[1] * x[1] + x[2], std::sin(x[3]) - x[1], -x[3] * x[3] * x[3] - x[2]};
  };
  Vector y(1, 0.5, -0.7, 1.2);
  PhiStepper stepper{y, chain, backward_euler, fixed_point()};
  for (int k = 0; k < 5; ++k) {
    Vector z = y;
    PhiStepper fresh{z, chain, backward_euler, fixed_point()};
    const StepReport one = stepper.step(y, 0, 0.3), other = fresh.step(z, 0, 0.3);
    REQUIRE((one && other));
    CHECK(one.iterations() == other.iterations());
    CHECK(y == z);
  }
}

TEST_CASE("far beyond the radius of contraction: ten digits of y, or a refusal") {
  // Acceleration solves for two unknowns at any |z| while rounding lets it. What it ends at must not be mapped once more:
  // that multiplies the rounding left by |φz|.
  using Complex = std::complex<double>;
  int steps = 0, refused = 0;
  double worst = 0;
  for (const double p : {0.3, 0.5, 1.0})
    for (double size = 1; size < 2e12; size *= 10)
      for (double angle = 0.1; angle < 6.2; angle += 0.5) {
        const Complex z = std::polar(size, angle), one{1, 0.5};
        Eigen::Matrix2d A;
        A << z.real(), -z.imag(), z.imag(), z.real();
        Eigen::Vector2d y{one.real(), one.imag()};
        PhiStepper stepper{y, [A](const Eigen::Vector2d& x) -> Eigen::Vector2d { return A * x; }, phi(p),
                           fixed_point()};
        ++steps;
        const StepReport report = stepper.step(y, 0, 1);
        if (!report) {
          CHECK((report.outcome() == Outcome::iteration_stalled || report.outcome() == Outcome::iteration_diverged));
          CHECK((y[0] == one.real() && y[1] == one.imag()));
          ++refused;
          continue;
        }
        const Complex exact = one * (1.0 + (1 - p) * z) / (1.0 - p * z);
        worst = std::max(worst, std::abs(Complex{y[0], y[1]} - exact) / std::max(1.0, std::abs(exact)));
      }
  CAPTURE(steps, refused, worst);
  CHECK(worst <= 1e-10);
  CHECK(refused < steps / 3);
}

TEST_CASE("mass matrices, float, a jump, a bad depth") {
  CHECK_THROWS_AS(fixed_point({.depth = 6}), std::invalid_argument);
}
