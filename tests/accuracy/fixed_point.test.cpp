// Fixed-point iteration: contraction by exactly φ²a² on an oscillator, convergence up to a = 1/φ and not beyond. Beside
// Newton, and of many unknowns: the stress tier.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <string>
#include <tuple>

#include "support/catch.hpp"
#if PHISTEP_FULL
#include "problems/oscillator.hpp"
#endif
#if PHISTEP_STRESS
#include "support/shared_force.hpp"
#endif

using namespace phistep;

#if PHISTEP_FULL

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

TEST_CASE("Verlet's solve for v iterates, and is Newton's for some steps where that fails") {
  using Vec = Eigen::VectorXd;
  const auto run = [](double most, double dt, const auto&... solver) {
    // Drags from 1 to `most`, each with a cubic part.
    const Vec drag = Vec::LinSpaced(40, 0, std::log(most)).array().exp();
    const auto f = [drag](const Vec& r, const Vec& v) -> Vec {
      return -r.array() - drag.array() * (v.array() + 0.1 * v.array().cube());
    };
    Motion<Vec> y{Vec::Ones(40), Vec::LinSpaced(40, -1, 1)};
    PhiStepper stepper{y, f, velocity_verlet, solver...};
    const RunReport report = integrate(stepper, y, {0, 40 * dt}, fixed(dt));
    CAPTURE(report.message());
    REQUIRE(report);
    return std::tuple{y, report.statistics, std::string(stepper.solver_name())};
  };
  const auto [mild, few, by_iteration] = run(10, 0.01);
  CHECK(by_iteration == "fixed-point iteration");
  CHECK(few.jacobians == 0);
  const auto [stiff, work, by_newton] = run(1e4, 0.01);
  CHECK(by_newton == "dense LU");
  CHECK(work.jacobians >= 1);
  CHECK(work.failed_steps == 0);
  const auto [iterated, calls, name] = run(10, 0.01, fixed_point());
  CHECK((mild.v - iterated.v).norm() <= 1e-12);
  CHECK(stiff.v.cwiseAbs().maxCoeff() < 1);
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

#elif PHISTEP_STRESS
// Fixed-point iteration beside Newton's, and of many unknowns: acceleration, tolerances, Verlet, masses.

using Vec = Eigen::VectorXd;

TEST_CASE("plain iteration of y' = lambda y contracts by phi |z|") {
  for (const double z : {-0.9, -0.5, 0.5}) {
    Vec y = Vec::Constant(1, 1.0);
    PhiStepper stepper{y, shared_force::OfState<Vec>{[z](const Vec& x) -> Vec { return z * x; }}, backward_euler,
                       fixed_point({.max_iterations = 15, .depth = 0})};
    const StepReport report = stepper.step(y, 0, 1);
    REQUIRE_FALSE(report);
    const Failure f = report.failure();
    for (std::size_t k = 1; k < 15; ++k)
      CHECK(std::abs(f.increments[k] / f.increments[k - 1] / std::abs(z) - 1) < 0.01);
  }
}

TEST_CASE("acceleration needs fewer iterations than plain iteration, and reaches beyond its limit") {
  // A chain of 40 springs, k = 1, m = 1: largest ω = 2, the contraction of plain iteration (φωΔt)².
  const shared_force::OfState<Vec> chain = [](const Vec& r) -> Vec {
    Vec f(r.size());
    const Eigen::Index n = r.size();
    for (Eigen::Index i = 0; i < n; ++i)
      f[i] = (i > 0 ? r[i - 1] : 0.0) - 2 * r[i] + (i + 1 < n ? r[i + 1] : 0.0) - 0.1 * r[i] * r[i] * r[i];
    return f;
  };
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Motion<Vec> begin{Vec(40), Vec(40)};
  for (auto& x : begin.r) x = 0.3 * normal(random);
  for (auto& x : begin.v) x = normal(random);
  const auto iterations = [&](double dt, auto solver) {
    Motion<Vec> y = begin, z = begin;
    PhiStepper stepper{y, chain, midpoint, solver};
    PhiStepper exact{z, chain, midpoint};
    const StepReport report = stepper.step(y, 0, dt);
    if (!report) return -1;
    REQUIRE(exact.step(z, 0, dt));
    CHECK((y.r - z.r).norm() <= 1e-14 * z.r.norm() * 20);
    return report.iterations();
  };
  const int plain = iterations(0.8, fixed_point({.depth = 0})), mixed = iterations(0.8, fixed_point({.depth = 3}));
  CAPTURE(plain, mixed);
  CHECK(mixed > 0);
  CHECK(plain > mixed);
  CHECK(iterations(1.1, fixed_point({.depth = 0})) == -1);
  CHECK(iterations(1.1, fixed_point({.depth = 5})) > 0);
}

TEST_CASE("a tolerance saves iterations and keeps its promise") {
  const shared_force::OfState<Vec> pendulum = [](const Vec& r) -> Vec { return -r.array().sin(); };
  Motion<Vec> y{Vec::Constant(1, 1.0), Vec::Zero(1)}, z = y, x = y;
  PhiStepper loose{y, pendulum, trapezoidal, fixed_point({.rtol = 1e-4, .atol = 1e-6})};
  PhiStepper tight{x, pendulum, trapezoidal, fixed_point()};
  PhiStepper exact{z, pendulum, trapezoidal};
  for (int k = 0; k < 10; ++k) {
    REQUIRE(loose.step(y, 0, 0.2));
    REQUIRE(tight.step(x, 0, 0.2));
    REQUIRE(exact.step(z, 0, 0.2));
  }
  CHECK(loose.statistics().iterations < tight.statistics().iterations);
  CHECK(std::abs(y.r[0] - z.r[0]) <= 10 * 1e-4);
  CHECK(std::abs(x.r[0] - z.r[0]) <= 1e-14);
}

TEST_CASE("Verlet with a velocity-dependent force without a Jacobian serves any number of unknowns") {
  // Coupled drag: each v is dragged by its neighbours', which no local force can say.
  const auto force = [](const Vec& r, const Vec& v) -> Vec {
    Vec f = -r - 0.5 * v;
    const Eigen::Index n = v.size();
    f.head(n - 1) += 0.2 * v.tail(n - 1);
    return f;
  };
  const auto run = [&](Eigen::Index n, auto... solver) {
    Motion<Vec> y{Vec::LinSpaced(n, 1, 2), Vec::LinSpaced(n, -1, 1)};
    PhiStepper stepper{y, force, velocity_verlet, solver...};
    for (int k = 0; k < 5; ++k) REQUIRE(stepper.step(y, 0, 0.1));
    return std::pair{y, stepper.statistics()};
  };
  const auto [few, calls] = run(900);
  const auto [same, by_iteration] = run(900, fixed_point());
  CHECK(calls.jacobians == 0);
  CHECK(by_iteration.jacobians == 0);
  CHECK((few.v - same.v).norm() <= 1e-14 * few.v.norm());
  const auto [many, counts] = run(5000);
  CHECK(counts.jacobians == 0);
  CHECK(counts.force_calls == 5 + counts.iterations);

  // A stepper made for few may meet many, and the other way.
  Motion<Vec> y{Vec::Ones(10), Vec::Ones(10)};
  PhiStepper stepper{y, force, velocity_verlet};
  REQUIRE(stepper.step(y, 0, 0.1));
  y = {Vec::Ones(2000), Vec::Ones(2000)};
  REQUIRE(stepper.step(y, 0, 0.1));
  y = {Vec::Ones(10), Vec::Ones(10)};
  REQUIRE(stepper.step(y, 0, 0.1));
}

TEST_CASE("mass matrices, float, a jump, a bad depth") {
  SECTION("a dense mass matrix") {
    Eigen::Matrix2d M;
    M << 2, 0.5, 0.5, 1;
    Motion<Vec> y{Vec::Ones(2), Vec::Zero(2)}, z = y;
    const shared_force::OfState<Vec> f = [](const Vec& r) -> Vec { return -r.array().cube(); };
    PhiStepper a{y, f, trapezoidal, mass(M), fixed_point()};
    PhiStepper b{z, f, trapezoidal, mass(M)};
    REQUIRE(a.step(y, 0, 0.3));
    REQUIRE(b.step(z, 0, 0.3));
    CHECK((y.r - z.r).norm() <= 1e-15);
  }
  SECTION("float") {
    Motion<Eigen::VectorXf> y{Eigen::VectorXf::Ones(3), Eigen::VectorXf::Zero(3)};
    PhiStepper a{y, [](const Eigen::VectorXf& r) -> Eigen::VectorXf { return -r; }, trapezoidal, fixed_point()};
    REQUIRE(a.step(y, 0.0F, 0.5F));
    CHECK(y.r[0] == Approx((1 - 0.0625) / (1 + 0.0625)).epsilon(1e-6));
  }
  SECTION("a jump has no fixed point: named, not endless") {
    Vec y = Vec::Constant(1, 0.3);
    const shared_force::OfState<Vec> jump = [](const Vec& x) -> Vec { return Vec::Constant(1, x[0] > 0 ? -1.0 : 1.0); };
    PhiStepper a{y, jump, backward_euler, fixed_point()};
    const StepReport report = a.step(y, 0, 1);
    CHECK((report.outcome() == Outcome::iteration_stalled || report.outcome() == Outcome::iteration_diverged));
    CHECK(y[0] == 0.3);
  }
  SECTION("depth") { CHECK_THROWS_AS(fixed_point({.depth = 6}), std::invalid_argument); }
}

#endif
