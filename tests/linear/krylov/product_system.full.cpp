// Products in linear stages: solves that follow the tolerance, their orders, what they cost.
#include <phistep/integrate.hpp>
#include <phistep/krylov.hpp>
#include <phistep/schemes/rosenbrock.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <vector>

#include "problems/reaction_diffusion.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace problems;
using Vec = Eigen::VectorXd;

namespace {

const ReactionDiffusion calm{.m = 12}, windy{.m = 12, .wind = 5};
struct Ended {
  Vec y;
  Statistics counts;
};
Ended run(const ReactionDiffusion& problem, auto scheme, double rtol, auto solver, double mass = 1) {
  Vec y = problem.start();
  const auto force = [&problem, mass](const Vec& u, double t) -> Vec { return mass * as_function(problem)(u, t); };
  PhiStepper stepper{y, force, scheme, phistep::mass(mass), solver};
  const auto report = integrate(stepper, y, {0.0, 0.05}, tolerance{.rtol = rtol, .atol = rtol});
  INFO(describe(report.outcome));
  REQUIRE(report);
  return {y, report.statistics};
}
double apart(const Vec& a, const Vec& b) { return (a - b).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE(
    "errors of Rosenbrock steps follow the tolerance as with a factorization, and solves cost less where less is "
    "asked") {
  const auto check = [](const ReactionDiffusion& problem, auto scheme, auto solver, double mass) {
    const Vec exact = run(problem, rodas4, 1e-10, newton()).y;
    // Below, what differences leave of a product is seen.
    for (const double rtol : {1e-3, 1e-4, 1e-5}) {
      const Ended direct = run(problem, scheme, rtol, newton()), krylov = run(problem, scheme, rtol, solver, mass);
      const double error = apart(krylov.y, exact), by_lu = apart(direct.y, exact);
      CAPTURE(rtol, error, by_lu, krylov.counts.linear_iterations, krylov.counts.solves);
      CHECK(error <= 1.3 * by_lu + 0.05 * rtol);
      CHECK(error >= 0.7 * by_lu - 0.05 * rtol);
      CHECK(std::abs(static_cast<double>(krylov.counts.steps - direct.counts.steps)) <=
            0.05 * static_cast<double>(direct.counts.steps) + 1);
    }
    // To 1e-10 whatever the tolerance:
    const Ended usual = run(problem, scheme, 1e-3, solver, mass);
    auto closely = solver;
    closely.options.linear_rtol = 1e-10;
    const Ended close = run(problem, scheme, 1e-3, closely, mass);
    CAPTURE(usual.counts.linear_iterations, close.counts.linear_iterations);
    CHECK(4 * usual.counts.linear_iterations <= 3 * close.counts.linear_iterations);
  };
  SECTION("Rodas4, conjugate gradients") {
    check(calm, rodas4, newton<MatrixFree<KrylovMethod::conjugate_gradients>>(), 1);
  }
  SECTION("Rodas4, BiCGSTAB, heavy") { check(windy, rodas4, newton<MatrixFree<>>(), 1e4); }
  SECTION("Rodas5P, light") { check(calm, rodas5p, newton<MatrixFree<KrylovMethod::conjugate_gradients>>(), 1e-4); }
}

TEST_CASE("without a tolerance, products are solved with to rounding, and Rodas4 keeps its order") {
  const auto steps = [](int count) {
    Vec y = calm.start();
    PhiStepper stepper{y, as_function(calm), rodas4, newton<MatrixFree<KrylovMethod::conjugate_gradients>>()};
    for (int k = 0; k < count; ++k) REQUIRE(stepper.step(y, 0, 0.02 / count));
    return y;
  };
  const Vec a = steps(4), b = steps(8), c = steps(16);
  const double order = std::log2(apart(a, b) / apart(b, c));
  CAPTURE(order);
  CHECK(std::abs(order - 4) < 0.6);
}

TEST_CASE("TR-BDF2 follows a tolerance with products alone, without masses") {
  const auto solved_by = [](auto solver) {
    Vec y = calm.start();
    PhiStepper stepper{y, as_function(calm), tr_bdf2, solver};
    REQUIRE(integrate(stepper, y, {0.0, 0.05}, tolerance{.rtol = 1e-4, .atol = 1e-4}));
    return y;
  };
  CHECK(apart(solved_by(newton<MatrixFree<KrylovMethod::conjugate_gradients>>()), solved_by(newton())) <= 1e-5);
}
