// "Success" means that the answer is right, to 100 κ rtol at the worst: on random stiff linear systems whose solutions are
// known, and on random networks of reactions. κ is what the problem itself makes of a small error, measured. The long
// form, beside CVODE, ARKODE and Odeint: tests/reference/truth.stress.cpp.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "support/catch.hpp"
#include "truth/linear.hpp"
#include "truth/schemes.hpp"
#include "truth/solution.hpp"

namespace {

using namespace truth;

std::uint64_t seed() {
  const char* text = std::getenv("PHISTEP_SEED");
  return text ? std::strtoull(text, nullptr, 10) : 7;
}

/// Three tolerances, three schemes.
void check(const Problem& problem) {
  using Run = Answer (*)(const Problem&, double);
  static constexpr std::pair<const char*, Run> schemes[] = {
      {"Rodas5P", [](const Problem& p, double rtol) { return run<Force>(p, phistep::rodas5p, rtol); }},
      {"Radau", [](const Problem& p, double rtol) { return run<Force>(p, phistep::radau, rtol); }},
      {"extrapolated Euler", [](const Problem& p, double rtol) {
         return run<Force>(p, phistep::extrapolated(phistep::backward_euler), rtol);
       }}};
  for (const auto& [name, scheme] : schemes)
    for (const double rtol : {1e-2, 1e-4, 1e-6}) {
      const Result result = judge(0, 0, problem, rtol, scheme(problem, rtol));
      CAPTURE(seed(), problem.name, problem.kappa, name, rtol, result.share, result.drift);
      CHECK(result.share >= 0);  // none fails here
      CHECK(result.share <= 100);
      // Mass is kept, to what rounding makes of f; found: 13, where the extrapolation's weights magnify it.
      CHECK(result.roundings <= 100);
    }
}

}  // namespace

TEST_CASE("successes are right on random stiff linear systems") {
  for (int k = 0; k < 20; ++k) check(linear_problem(seed(), k));
}

TEST_CASE("successes are right on random networks of reactions") {
  // The quick ones of the first: their answers take longest.
  for (const int k : {3, 6, 8, 9, 10, 2, 14, 1}) check(network_problem(seed(), k).problem);
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
