// A step that an event, or a time given, cuts short is a step like any other: every scheme, forward and backward.
#include "acceptance/cut_steps_cases.hpp"

using namespace cut_steps;

TEST_CASE("events and given times change nothing of a controlled run: first order") {
  check_cuts("radau", of_rotation(phistep::radau), {1e-2, 1e-4, 1e-6, 1e-9, 1e-12});
  check_cuts("radau(3)", of_rotation(phistep::radau(3)), {1e-2, 1e-4, 1e-6});
  check_cuts("rodas4", of_rotation(phistep::rodas4), {1e-2, 1e-4, 1e-6, 1e-8});
  check_cuts("rodas5p", of_rotation(phistep::rodas5p), {1e-2, 1e-4, 1e-6, 1e-8});
}
TEST_CASE("events and given times change nothing of a controlled run: low orders") {
  check_cuts("forward_euler", of_rotation(phistep::forward_euler), {1e-2, 1e-3});
  check_cuts("phi(0.7)", of_rotation(phistep::phi(0.7)), {1e-2, 1e-3});
  check_cuts("trapezoidal", of_rotation(phistep::trapezoidal), {1e-2, 1e-4, 1e-6});
  check_cuts("midpoint", of_rotation(phistep::midpoint), {1e-2, 1e-4, 1e-6});
  check_cuts("backward_euler", of_rotation(phistep::backward_euler), {1e-2, 1e-3});
  check_cuts("tr_bdf2", of_rotation(phistep::tr_bdf2), {1e-2, 1e-4, 1e-6});
}
TEST_CASE("events and given times change nothing of a controlled run: stiff") {
  check_cuts("radau", of_stiff(phistep::radau), {1e-2, 1e-4, 1e-6, 1e-9, 1e-12}, false);
  check_cuts("rodas4", of_stiff(phistep::rodas4), {1e-2, 1e-4, 1e-6, 1e-8}, false);
  check_cuts("trapezoidal", of_stiff(phistep::trapezoidal), {1e-2, 1e-4, 1e-6}, false);
  check_cuts("tr_bdf2", of_stiff(phistep::tr_bdf2), {1e-2, 1e-4, 1e-6}, false);
}
TEST_CASE("events and given times change nothing of a controlled run: motion") {
  check_cuts("velocity_verlet", of_motion(phistep::velocity_verlet), {1e-2, 1e-4, 1e-6});
  check_cuts("rkn86", of_motion(phistep::rkn86), {1e-3, 1e-6, 1e-9});
  check_cuts("rkn1210", of_motion(phistep::rkn1210), {1e-3, 1e-6, 1e-9});
  check_cuts("radau", of_motion(phistep::radau), {1e-4, 1e-6, 1e-9});
  check_cuts("trapezoidal", of_motion(phistep::trapezoidal), {1e-2, 1e-4, 1e-6});
  check_cuts("rodas5p", of_motion(phistep::rodas5p), {1e-4, 1e-6});
}
