// Different ways to one answer, over generated problems.
#include "contract/agreement.hpp"

TEST_CASE("every solver finds the same solution") {
  property::report("six ways to solve: one solution", 10000, agreement::solvers);
}
TEST_CASE("springs, by conjugate gradients and by LU") {
  property::report("springs by CG and by dense LU: one solution", 10000, agreement::networks);
}
TEST_CASE("a controlled run ends where, when and as near as asked") {
  property::report("smooth problems: error <= 10 kappa rtol, at t1", 1000, agreement::runs);
}
