// Newton without a matrix: products from the force, from automatic differentiation, from differences.
#include "linear/krylov/tangent_product_cases.hpp"
#if PHISTEP_FULL
#include "support/shared_force.hpp"
#endif
#if PHISTEP_STRESS
#include <phistep/autodiff.hpp>
#include <phistep/sparse.hpp>

#endif

using namespace tangent_product_cases;

#if PHISTEP_FULL

TEST_CASE("heat on 100 x 100 points without a matrix: the exact factor of an eigenvector") {
  constexpr Index m = 100;
  Counts c;
  const double dt = 1e-3;
  const double z = eigenvalue(m, 2, 3) * dt, w = eigenvalue(m, 7, 1) * dt;
  const Vec a = mode(m, 2, 3), b = 0.5 * mode(m, 7, 1);
  const auto run = [&](auto force, auto solver) {
    Vec y = a + b;
    PhiStepper stepper{y, force, backward_euler, solver};
    double worst = 0;
    for (int k = 1; k <= 3; ++k) {
      problems::step(stepper, y, 0.0, dt);
      const Vec exact = std::pow(1 - z, -k) * a + std::pow(1 - w, -k) * b;
      worst = std::max(worst, (y - exact).norm() / exact.norm());
    }
    return std::pair{worst, stepper.statistics()};
  };
  const auto check = [&](const std::pair<double, Statistics>& done) {
    const Statistics& s = done.second;
    CHECK(done.first <= 1e-13);  // rounding: W's condition number is 1 + 8·101²·dt = 83
    CHECK(s.jacobians + s.factorizations == 0);
    CHECK(s.linear_iterations > 0);
    CHECK(s.solves == s.iterations);
    CHECK(s.force_calls == c.calls);
    return s;
  };
  SECTION("products from the force") {
    const Statistics s = check(
        run(HeatWithProduct{{m, &c.calls, &c.products}}, newton<MatrixFree<KrylovMethod::conjugate_gradients>>()));
    CHECK(s.force_calls == s.iterations);
    CHECK(c.products >= s.linear_iterations);
  }
  SECTION("products by differences: one force call each") {
    const Statistics s = check(run(Heat2d{m, &c.calls, &c.products}, newton<MatrixFree<>>()));
    CHECK(s.force_calls >= s.iterations + s.linear_iterations);
  }
}

TEST_CASE("a motion: K and C in one product, terms of a sum with products and with entries") {
  Motion<Vec> y{Vec::LinSpaced(200, -1, 1).array().sin(), Vec::LinSpaced(200, 2, 1)};
  const Vec masses = Vec::LinSpaced(200, 1, 3);
  const Gravity weight{Eigen::Vector2d(0, -1)};
  PhiStepper stepper{y, term(ChainWithProduct{}) + LinearDrag{0.3} + weight, trapezoidal, mass(masses),
                     newton<MatrixFree<>>()};
  const auto force = [&](const Motion<Vec>& at) -> Vec {
    Vec f = Chain{}(at.r, at.v) - 0.3 * at.v;
    for (Index i = 1; i < 200; i += 2) f[i] -= masses[i];
    return f;
  };
  for (int k = 0; k < 4; ++k) {
    const Motion<Vec> before = y;
    problems::step(stepper, y, 0.0, 0.2);
    // The trapezoidal rule's own equations.
    CHECK((y.r - before.r - 0.1 * (y.v + before.v)).norm() <= 1e-13 * y.r.norm());
    const Vec kick = masses.cwiseProduct(y.v - before.v);
    CHECK((kick - 0.1 * (force(y) + force(before))).norm() <= 1e-11 * kick.norm());
  }
}

TEST_CASE("failures of products are named, and nothing moves") {
  Counts c;
  constexpr Index m = 20;
  Vec y = mode(m, 1, 2) + mode(m, 3, 3);
  const Vec start = y;
  PhiStepper stepper{y, Nan{{m, &c.calls, &c.products}}, backward_euler,
                     newton<MatrixFree<KrylovMethod::conjugate_gradients>>()};
  CHECK(stepper.step(y, 0, 1e-2).outcome() == Outcome::non_finite_jacobian);
  CHECK((y.array() == start.array()).all());
}

TEST_CASE("a preconditioner of one's own, and a tolerance") {
  Counts c;
  constexpr Index m = 20;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  Vec y(m * m);
  for (auto& x : y) x = normal(random);
  Vec z = y;
  PhiStepper loose{y, HeatWithProduct{{m, &c.calls, &c.products}}, backward_euler,
                   newton<MatrixFree<KrylovMethod::conjugate_gradients, Own>>({.rtol = 1e-4, .atol = 1e-6})};
  REQUIRE(loose.step(y, 0, 1e-3));
  CHECK(Own::setups == loose.statistics().iterations);
  PhiStepper tight{z, HeatWithProduct{{m, &c.calls, &c.products}}, backward_euler,
                   newton<MatrixFree<KrylovMethod::conjugate_gradients>>()};
  REQUIRE(tight.step(z, 0, 1e-3));
  CHECK(loose.statistics().linear_iterations < tight.statistics().linear_iterations);
  CHECK((y - z).norm() <= 1e-4 * z.norm());
}

TEST_CASE("products by differences are taken from the force itself, not from what a solve has left of it") {
  const shared_force::OfState<Vec> f = [](const Vec& x) -> Vec { return -2 * x - x.cwiseProduct(x); };
  const auto end = [&](auto solver) {
    Vec y = Vec::LinSpaced(2, 1, 2);
    PhiStepper stepper{y, f, phi(0.7), solver};
    for (int n = 0; n < 10; ++n) {
      const StepReport report = stepper.step(y, 0.1 * n, 0.1);
      INFO(report.message());
      REQUIRE(report);
    }
    return y;
  };
  const Vec tight = end(newton()), loose = end(newton<MatrixFree<>>({.rtol = 1e-4, .atol = 1e-6}));
  CHECK((loose - tight).norm() < 1e-4 * tight.norm());
}

TEST_CASE("a state of few unknowns, known at compile time") {
  Eigen::Vector2d y{1, 2};
  PhiStepper stepper{y, [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return -2 * x; }, trapezoidal,
                     newton<MatrixFree<>>()};
  problems::step(stepper, y, 0.0, 0.1);
  CHECK((y - Eigen::Vector2d(1, 2) * (0.9 / 1.1)).norm() <= 1e-14);
}

#elif PHISTEP_STRESS
// Products for every solver, kind of state and unit.

TEST_CASE("the Brusselator on 71 x 71 points: differences and automatic differentiation solve the same equations") {
  const Brusselator problem{71};
  const Vec start = problem.start();
  REQUIRE(start.size() == 10082);
  const double dt = 0.05;
  const auto run = [&](auto force) {
    Vec y = start;
    PhiStepper stepper{y, force, backward_euler, newton<MatrixFree<>>()};
    for (int k = 0; k < 3; ++k) {
      const Vec before = y;
      const StepReport report = stepper.step(y, 0, dt);
      INFO(report.message());
      REQUIRE(report);
      // y⁺ − y = Δt Ψ(y⁺), to what rounding leaves in Ψ: 8α·71²Δt·u·|y| = 80·0.05·u·|y|
      CHECK((y - before - dt * problem(y)).cwiseAbs().maxCoeff() <= 1e-13 * y.cwiseAbs().maxCoeff());
    }
    CHECK(stepper.statistics().jacobians == 0);
    return std::pair{y, stepper.statistics()};
  };
  const auto [by_differences, few] = run([&](const Vec& y) -> Vec { return problem(y); });
  const auto [by_autodiff, many] = run(autodiff(problem));
  CHECK((by_differences - by_autodiff).norm() <= 1e-12 * by_autodiff.norm());
  // A directional derivative is no force call.
  CHECK(many.force_calls == many.iterations);
  CHECK(few.force_calls == few.iterations + 2 * few.linear_iterations);
  Vec y = start;
  CHECK_THROWS_AS((PhiStepper{y, [&](const Vec& x) -> Vec { return problem(x); }, backward_euler}),
                  std::invalid_argument);
}

TEST_CASE("a motion: K and C in one product, terms of a sum with products and with entries") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Motion<Vec> start{Vec(200), Vec(200)};
  for (auto& x : start.r) x = normal(random);
  for (auto& x : start.v) x = normal(random);
  const Vec masses = Vec::LinSpaced(200, 1, 3);
  const auto run = [&](auto force, auto scheme, auto solver) {
    Motion<Vec> y = start;
    PhiStepper stepper{y, force + LinearDrag{0.3} + Gravity{Eigen::Vector2d(0, -1)}, scheme, mass(masses), solver};
    for (int k = 0; k < 4; ++k) {
      const StepReport report = stepper.step(y, 0, 0.2);
      INFO(report.message());
      REQUIRE(report);
    }
    return y;
  };
  const auto compare = [&](auto scheme) {
    const Motion<Vec> exact = run(term(Chain{}), scheme, newton());
    const auto check = [&](const Motion<Vec>& y) {
      CHECK((y.r - exact.r).norm() <= 1e-13 * exact.r.norm());
      CHECK((y.v - exact.v).norm() <= 1e-13 * exact.v.norm());
    };
    check(run(term(Chain{}), scheme, newton<MatrixFree<>>()));
    check(run(term(ChainWithProduct{}), scheme, newton<MatrixFree<>>()));
  };
  compare(trapezoidal);
  compare(midpoint);
  compare(velocity_verlet);
}

TEST_CASE("units: lengths, times and masses scaled by powers of two change no count and no bit") {
  const auto run = [](double length, double time) {
    Motion<Vec> y{Vec::LinSpaced(50, 1, 2) * length, Vec::LinSpaced(50, -1, 1) * length / time};
    const auto force = [=](const Vec& r, const Vec& v) -> Vec {
      Vec f = -(r.array() / length).cube().matrix() * length / (time * time) - 0.1 * v / time;
      f.head(49) += (r.tail(49) - r.head(49)) / (time * time);
      return f;
    };
    PhiStepper stepper{y, force, backward_euler, newton<MatrixFree<>>()};
    for (int k = 0; k < 3; ++k) REQUIRE(stepper.step(y, 0, 0.25 * time));
    return std::pair{Vec(y.r / length), stepper.statistics()};
  };
  const auto [r, s] = run(1, 1);
  const auto [scaled_r, scaled_s] = run(std::ldexp(1.0, -31), std::ldexp(1.0, -45));  // about 1e-10 m, 1e-14 s
  CHECK((r.array() == scaled_r.array()).all());
  CHECK(s == scaled_s);
}

TEST_CASE("failures of products are named, and nothing moves") {
  Counts c;
  constexpr Index m = 20;
  Vec y = mode(m, 1, 2) + mode(m, 3, 3);
  const Vec start = y;
  SECTION("the wrong sign") {
    PhiStepper stepper{y, HeatWithWrongSign{{m, &c.calls, &c.products}}, backward_euler,
                       newton<MatrixFree<KrylovMethod::gmres>>()};
    const StepReport report = stepper.step(y, 0, 1e-2);
    CHECK_FALSE(report);
    CAPTURE(report.message());
    CHECK((report.outcome() == Outcome::newton_diverged || report.outcome() == Outcome::newton_stalled ||
           report.outcome() == Outcome::linear_solver_failed));
  }
  SECTION("a product that isn't finite") {
    PhiStepper stepper{y, Nan{{m, &c.calls, &c.products}}, backward_euler, newton<MatrixFree<>>()};
    CHECK(stepper.step(y, 0, 1e-2).outcome() == Outcome::non_finite_jacobian);
  }
  SECTION("a singular matrix") {
    PhiStepper stepper{y, Null{}, backward_euler, newton<MatrixFree<>>()};  // W = 1 − 1·1 = 0
    const StepReport report = stepper.step(y, 0, 1.0);
    CAPTURE(report.message());
    CHECK_FALSE(report);
  }
  CHECK((y.array() == start.array()).all());
}

TEST_CASE("a state of several blocks and units: products of every kind, and fixed-point iteration, agree with Newton") {
  const auto run = [](auto force, auto solver) {
    Warm y{Vec::LinSpaced(30, -1, 1), Vec::LinSpaced(30, 2, 1), Vec::Constant(30, 310)};
    PhiStepper stepper{y, force, trapezoidal, solver};
    for (int k = 0; k < 5; ++k) {
      const StepReport report = stepper.step(y, 0, 0.1);
      INFO(report.message());
      REQUIRE(report);
    }
    return y;
  };
  const Warm exact = run(WarmForce{}, newton());
  const auto check = [&](const Warm& y) {
    CHECK((y.r - exact.r).norm() <= 1e-13 * exact.r.norm());
    CHECK((y.v - exact.v).norm() <= 1e-13 * exact.v.norm());
    CHECK((y.T - exact.T).norm() <= 1e-13 * exact.T.norm());
  };
  check(run(WarmForce{}, newton<MatrixFree<>>()));
  check(run(WarmWithProduct{}, newton<MatrixFree<>>()));
  check(run(WarmWithEntries{}, newton<MatrixFree<>>()));
  check(run(WarmForce{}, fixed_point()));
  check(run(WarmForce{}, fixed_point({.depth = 0})));
}

#endif
