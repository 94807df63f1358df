// Differences by colour: as few force calls as the pattern allows, and the steps that analytic tangents give.
#include <Eigen/SparseCholesky>

#include "problems/march.hpp"
#include "step/jacobian/difference_tangent_cases.hpp"
#include "support/shared_force.hpp"

using namespace difference_tangent_cases;

// Compiles in half the time of SparseLU, which the full half takes.
const auto ldlt = newton<Eigen::SimplicialLDLT<Sparse>>();

TEST_CASE("one-dimensional heat of 5000 points: three force calls a Jacobian, no dense matrix") {
  constexpr int n = 5000;
  Vec u = wave(n);
  const Statistics s = steps(u, sparsity(heat, tridiagonal(n)), backward_euler, 3, ldlt);
  CHECK(s.jacobians == 1);
  CHECK(s.force_calls == s.iterations + 3 * s.jacobians);
  Vec exact = wave(n);
  // (1 − Δt A) u⁺ = u of constant diagonals: elimination of the row below, then backwards.
  for (int k = 0; k < 3; ++k) {
    Vec pivot(n);
    for (int i = 0; i < n; ++i) {
      pivot[i] = i == 0 ? 11 : 11 - 25 / pivot[i - 1];
      if (i > 0) exact[i] += 5 / pivot[i - 1] * exact[i - 1];
    }
    for (int i = n - 1; i >= 0; --i) exact[i] = (exact[i] + (i + 1 < n ? 5 * exact[i + 1] : 0.0)) / pivot[i];
  }
  // Newton iterates to rounding: κ(W) = 1 + 0.1·200 rounding errors of the size of u, in each of three steps.
  CHECK((u - exact).cwiseAbs().maxCoeff() <= 3 * 21 * 8 * 2.3e-16);
}

TEST_CASE("a resized state gets a pattern of its size; a pattern that can't fit throws and leaves the stepper") {
  Vec u = wave(5);
  Sparse five = tridiagonal(5);
  PhiStepper stepper{u, sparsity(heat, five), backward_euler, ldlt};
  REQUIRE(stepper.step(u, 0, 0.1));
  Vec longer = wave(8);
  const Vec before = longer;
  CHECK_THROWS_AS(stepper.step(longer, 0, 0.1), std::invalid_argument);
  CHECK(same_bits(longer, before));
  CHECK(stepper.step(u, 0.1, 0.1));  // under AddressSanitizer: nothing was left half resized
  CHECK_THROWS_AS((PhiStepper{longer, sparsity(heat, five), backward_euler, ldlt}), std::invalid_argument);
}

TEST_CASE("a dense Jacobian by differences of more than 1000 unknowns is refused, in words that name what to do") {
  const Vec u = wave(1001);
  for (const std::string cure : {"1001 unknowns", "sparsity(f, pattern)", "newton<MatrixFree<Eigen::BiCGSTAB>>()",
                                 "<phistep/krylov.hpp>", "fixed_point()", "jacobian(...)"})
    CHECK_THROWS_WITH((PhiStepper{u, heat, backward_euler}), contains(cure));
}

TEST_CASE("differences are taken from the force itself, not from what a solve has left of it") {
  // phi > 1/2 carries the force from solve to solve, off by what solves to a tolerance leave. A Jacobian by differences
  // from there was off by that over the increment: Newton converged on it, to something else.
  using V2 = Eigen::Vector2d;
  const shared_force::OfState<V2> f = [](const V2& x) -> V2 { return -2 * x - x.cwiseProduct(x); };
  const auto end = [&](auto solver) {
    V2 y(1, 2);
    PhiStepper stepper{y, f, phi(0.7), solver};
    for (int n = 0; n < 10; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
    return y;
  };
  const V2 tight = end(newton()), loose = end(newton({.rtol = 1e-4, .atol = 1e-6}));
  CHECK((loose - tight).norm() < 1e-4 * tight.norm());
}
