// Edited motions, every scheme; the quick half is edits.test.cpp.
#include "stepper/edits_cases.hpp"

using namespace edits_cases;

// Pull knows no velocity: Verlet carries it from step to step.
TEST_CASE("every scheme, dynamic motion: edited states are stepped as by a fresh stepper") {
  check_all<SecondOrder<Dynamic>>(Pull{});
}
TEST_CASE("every scheme, fixed motion") { check_all<SecondOrder<Fixed>>(Pull{}); }
