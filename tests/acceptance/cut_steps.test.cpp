// A step that an event, or a time given, cuts short is a step like any other: same scheme, same order, same error test.
#include "acceptance/cut_steps_cases.hpp"

using namespace cut_steps;

TEST_CASE("events and given times change nothing of a controlled run: radau") {
  check_cuts("radau", of_rotation(phistep::radau), {1e-4, 1e-6, 1e-9});
}
TEST_CASE("events and given times change nothing of a controlled run: a scheme that estimates, one that looks back") {
  check_cuts("rodas4", of_rotation(phistep::rodas4), {1e-4, 1e-7});
  check_cuts("trapezoidal", of_rotation(phistep::trapezoidal), {1e-3, 1e-5});
}
TEST_CASE("events and given times change nothing of a controlled run: motion, steps in halves") {
  check_cuts("velocity_verlet", of_motion(phistep::velocity_verlet), {1e-3, 1e-5});
}
