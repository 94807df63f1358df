// "Success" means that the answer is right, as in truth.full.cpp: Rodas5P on random networks of reactions.

#include "accuracy/truth/solution.hpp"
#include "accuracy/truth_cases.hpp"

namespace {

void check(const Problem& problem) {
  check(problem, "Rodas5P", [](const Problem& p, double rtol) { return run<Force>(p, phistep::rodas5p, rtol); });
}

}  // namespace

TEST_CASE("successes are right on random networks of reactions") {
  // The quick ones of the first: their answers take longest.
  for (const int k : {3, 6, 8, 9, 10, 2, 14, 1}) check(network_problem(seed(), k).problem);
}
