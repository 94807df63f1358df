// "Success" means that the answer is right, to 100 κ rtol at the worst: on random stiff linear systems whose solutions
// are known. κ is what the problem itself makes of a small error, measured. Here extrapolated Euler; the others:
// truth.full.cpp.

#include "acceptance/truth_cases.hpp"

namespace {

void check(const Problem& problem) {
  check(problem, "extrapolated Euler", [](const Problem& p, double rtol) {
    return run<Force>(p, phistep::extrapolated(phistep::backward_euler), rtol);
  });
}

}  // namespace

TEST_CASE("successes are right on random stiff linear systems") {
  for (int k = 0; k < 20; ++k) check(linear_problem(seed(), k));
}
