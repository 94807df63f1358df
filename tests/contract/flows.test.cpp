// Properties of steps of vectors, over generated forces, masses, sizes and steps. By every kind of stepper, and sums of
// terms: flows.full.cpp.
#define PHISTEP_ENDPOINT_FLOWS
#include "contract/flows_steps.hpp"

TEST_CASE("a linear force makes a linear map of a step") { property::check("linearity", 300, flows::linearity); }
TEST_CASE("a step and its adjoint backward are nothing") { property::check("reversal", 300, flows::reversal); }
TEST_CASE("momentum, angular momentum, quadratic energy") { property::check("conservation", 200, flows::conservation); }
TEST_CASE("the unit of force changes no bit") { property::check("units", 200, flows::scaling); }
