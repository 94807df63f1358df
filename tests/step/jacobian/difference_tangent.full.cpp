// Differences by colour beside differences by column, for every kind of state; the quick half is
// difference_tangent.test.cpp.
#include "step/jacobian/difference_tangent_cases.hpp"

using namespace difference_tangent_cases;

TEST_CASE("one-dimensional heat of 5000 points: three force calls a Jacobian, no dense matrix") {
  constexpr int n = 5000;
  const auto check = [](auto force) {
    Vec u = wave(n);
    const Statistics s = steps(u, force, backward_euler, 3);
    CHECK(s.jacobians == 1);
    CHECK(s.force_calls == s.iterations + 3 * s.jacobians);
    return u;
  };
  const Vec by_sparsity = check(sparsity(heat, tridiagonal(n)));
  Vec exact = wave(n);
  const Sparse A = tridiagonal(n);
  Eigen::SparseLU<Sparse> lu(Sparse(Sparse(Vec::Ones(n).asDiagonal()) - 0.1 * A));
  for (int k = 0; k < 3; ++k) exact = lu.solve(exact).eval();
  // Newton iterates to rounding: κ(W) = 1 + 0.1·200 rounding errors of the size of u, in each of three steps.
  CHECK((by_sparsity - exact).cwiseAbs().maxCoeff() <= 3 * 21 * 8 * 2.3e-16);
}

TEST_CASE("a motion: K and C by three calls each, and the same steps as by columns") {
  constexpr int n = 30;
  const Motion<Vec> start{wave(n), wave(n).reverse()};
  Motion<Vec> by_color = start, by_column = start;
  const Statistics few = steps(by_color, sparsity(chain, tridiagonal(n)), trapezoidal, 5);
  const Statistics many = steps(by_column, chain, trapezoidal, 5);
  CHECK(few.force_calls == 5 + few.iterations + 6 * few.jacobians);
  CHECK(many.force_calls == 5 + many.iterations + 2 * n * many.jacobians);
  CHECK(few.iterations == many.iterations);
  // Both iterate to rounding; a few units in the last place of a state of size 1 in each of five steps.
  CHECK((by_color.r - by_column.r).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
  CHECK((by_color.v - by_column.v).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
}

TEST_CASE("a resized state gets a pattern of its size; a pattern that can't fit throws and leaves the stepper") {
  Vec u = wave(5);
  Sparse five = tridiagonal(5);
  PhiStepper stepper{u, sparsity(heat, five), backward_euler};
  REQUIRE(stepper.step(u, 0, 0.1));
  Vec longer = wave(8);
  const Vec before = longer;
  CHECK_THROWS_AS(stepper.step(longer, 0, 0.1), std::invalid_argument);
  CHECK(same_bits(longer, before));
  CHECK(stepper.step(u, 0.1, 0.1));  // under AddressSanitizer: nothing was left half resized
  CHECK_THROWS_AS((PhiStepper{longer, sparsity(heat, five), backward_euler}), std::invalid_argument);
}

TEST_CASE("several blocks: the pattern runs over all unknowns, and a colour may span blocks") {
  constexpr int n = 40;
  const Warm start{wave(n), Vec::Constant(n, 0.5), Vec::LinSpaced(n, 0.1, 1)};
  Warm by_color = start, by_column = start;
  const Statistics few = steps(by_color, PatternedFriction{}, backward_euler, 5);
  const Statistics many = steps(by_column, Friction{}, backward_euler, 5);
  // Columns of v_i and T_i share rows: two colours for C. Those of r: one for K.
  CHECK(few.force_calls == few.iterations + 3 * few.jacobians);
  CHECK(many.force_calls == many.iterations + 3 * n * many.jacobians);
  CHECK(few.iterations == many.iterations);
  CHECK((by_color.v - by_column.v).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
  CHECK((by_color.T - by_column.T).cwiseAbs().maxCoeff() <= 5 * 8 * 2.3e-16);
}

TEST_CASE("a stiff kick is measured again, by colour as by column") {
  // The force at the start throws u far beyond what the step then moves: the tangent there is another one.
  constexpr int n = 20;
  const auto stiff = [](const Vec& u) -> Vec { return -1e6 * (u.array() - 1).cube() - 1e8 * (u.array() - 1); };
  Sparse diagonal(n, n);
  diagonal.setIdentity();
  Vec by_color = Vec::Constant(n, 1.001), by_column = by_color;
  const Statistics few = steps(by_color, sparsity(stiff, diagonal), backward_euler, 1);
  const Statistics many = steps(by_column, stiff, backward_euler, 1);
  CHECK(few.jacobians == many.jacobians);
  CHECK(few.jacobians > 1);
  CHECK(few.force_calls == few.iterations + few.jacobians);
  CHECK(same_bits(by_color, by_column));
}

TEST_CASE("a force that is changed between steps brings its new pattern") {
  Vec u = wave(50);
  PhiStepper stepper{u, Coupled{1}, backward_euler};
  REQUIRE(stepper.step(u, 0, 0.1));
  const Statistics before = stepper.statistics();
  stepper.force().reach = 3;
  REQUIRE(stepper.step(u, 0.1, 0.1));
  const Statistics change = stepper.statistics() - before;
  CHECK(change.jacobians == 1);
  CHECK(change.force_calls == change.iterations + 4);
}

TEST_CASE("a force kept outside is asked for its pattern too") {
  auto force = sparsity(heat, tridiagonal(2000));
  Vec u = wave(2000);
  const Statistics s = steps(u, std::ref(force), trapezoidal, 1);
  CHECK(s.force_calls == s.iterations + 3 * s.jacobians);
}

TEST_CASE("a spring stretched at the start, slack at the end: its first tangent's crawl is no convergence") {
  // Across itself a long spring is stiff, W = 1 + 0.3 k Δt²; at its rest length it isn't, W = 1. Corrections by the first
  // tangent then fall by a factor near 1 and are small beside what they leave.
  using Vector = Eigen::VectorXd;
  Vector start(6);
  start << 0, 0.1, 0.1, 1.1, 0.3, 0;
  for (const double k : {1e3, 1e4, 1e5, 1e6}) {
    const auto spring = [k](const Vector& r) -> Vector {
      const Eigen::Vector3d d = r.tail<3>() - r.head<3>(), pull = k * (d.norm() - 1) / d.norm() * d;
      Vector f(6);
      f << pull, -pull;
      return f;
    };
    phistep::Motion<Vector> y{start, Vector::Zero(6)};
    phistep::PhiStepper stepper{y, spring, phistep::backward_euler};
    const double dt = 0.1;
    REQUIRE(stepper.step(y, 0, dt));
    CAPTURE(k);
    // Rounding of r ≈ 1, once in each of some sums, reaches the residual times k Δt.
    CHECK((y.v - dt * spring(y.r)).cwiseAbs().maxCoeff() <= 8 * 2.2e-16 * (1 + k * dt));
  }
}
