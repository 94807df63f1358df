// The linear systems whose solvers are dear to compile. The quick half is systems.test.cpp.
#include <Eigen/IterativeLinearSolvers>

#include "step/matrix/systems_cases.hpp"

using namespace systems_cases;

namespace {

using Llt = SparseSystem<double, Eigen::SimplicialLLT<Sparse>>;
using Cg = SparseSystem<double, Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper>>;

}  // namespace

TEMPLATE_TEST_CASE("solves with W, again with new values, again with a new pattern", "", Llt, Cg) {
  SystemOf<TestType> system;
  check_new_values_and_patterns(system);
}

TEMPLATE_TEST_CASE("a solver for definite matrices refuses an indefinite one", "", Llt) {
  SystemOf<TestType> system;
  check_indefinite(system);
}

TEST_CASE("conjugate gradients on an indefinite matrix either solve or say that they failed") {
  SystemOf<Cg> system;
  Statistics counts;
  const Mat C = Vec::LinSpaced(n, -30, 90).asDiagonal();
  fill(system, Mat::Zero(n, n), C);
  REQUIRE(system.factorize(gamma_force, 0, counts) == Outcome::success);
  const Vec b = Vec::Ones(n);
  Vec x = b;
  const Mat W = 2 * Mat::Identity(n, n) - gamma_force * C;
  const Outcome outcome = system.solve(x);
  CHECK((outcome == Outcome::linear_solver_failed || (W * x - b).norm() <= 1e-10));
}
