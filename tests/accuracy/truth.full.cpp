// "Success" means that the answer is right, to 100 κ rtol at the worst: on random stiff linear systems whose solutions
// are known; truth_networks.stress.cpp: on random networks of reactions. κ is what the problem itself makes of a small
// error, measured. In short, tolerance.test.cpp asks the same of single problems. The long form, beside
// CVODE, ARKODE and Odeint: tests/accuracy/reference/truth.stress.cpp.

#include "accuracy/truth_cases.hpp"

namespace {

void check(const Problem& problem) {
  check(problem, "Radau", [](const Problem& p, double rtol) { return run<Force>(p, phistep::radau, rtol); });
  check(problem, "Rodas4P2", [](const Problem& p, double rtol) { return run<Force>(p, phistep::rodas4p2, rtol); });
  check(problem, "Rodas5P", [](const Problem& p, double rtol) { return run<Force>(p, phistep::rodas5p, rtol); });
}

}  // namespace

TEST_CASE("successes are right on random stiff linear systems") {
  for (int k = 0; k < 20; ++k) check(linear_problem(seed(), k));
}

TEST_CASE("the random linear systems are what they say") {
  for (int k = 0; k < 10; ++k) {
    const Problem problem = linear_problem(seed(), k);
    const auto n = problem.start.size();
    CAPTURE(seed(), problem.name);
    // f(0, y) by differences along each component is A, to the rounding of f.
    Eigen::MatrixXd A(n, n);
    problem.jacobian(0, problem.start.data(), A.data());
    Eigen::VectorXd f(n), moved(n);
    problem.rate(0, problem.start.data(), f.data());
    for (Eigen::Index j = 0; j < n; ++j) {
      Eigen::VectorXd y = problem.start;
      y[j] += 1;
      problem.rate(0, y.data(), moved.data());
      CHECK((moved - f - A.col(j)).norm() <= 1e-10 * A.norm() * (1 + problem.start.norm()));
    }
    CHECK(problem.kappa >= 1);
    CHECK(problem.exact.allFinite());
  }
}
