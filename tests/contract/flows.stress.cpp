// Properties of steps of vectors, over generated forces, masses, sizes and steps.
#include "contract/flows.hpp"

TEST_CASE("a linear force makes a linear map of a step") {
  property::report("a linear force: the step is a linear map", 30000, flows::linearity);
}
TEST_CASE("a step and its adjoint backward are nothing") {
  property::report("phi forward, 1 - phi backward: returns", 30000, flows::reversal);
}
TEST_CASE("momentum, angular momentum, quadratic energy") {
  property::report("momentum at any phi; midpoint: L, quadratic E", 20000, flows::conservation);
}
TEST_CASE("the unit of force changes no bit") {
  property::report("force and mass times 2^k: the same bits", 20000, flows::scaling);
}
TEST_CASE("terms add up in any grouping") {
  property::report("sums of terms, zero terms, terms as kicks", 10000, flows::sums);
}
