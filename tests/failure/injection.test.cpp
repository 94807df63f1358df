// NaN, infinity or an exception at every force call of a step: the state keeps every bit, and nothing is silent.
#include "failure/injection_cases.hpp"

using namespace injection_cases;

TEST_CASE("every call of every scheme, dynamic motion, f(r)") {
  inject<SecondOrder<Dynamic>, Struck>(velocity_verlet);
  inject<SecondOrder<Dynamic>, Struck>(trapezoidal);
}

TEST_CASE("every call of every scheme, fixed motion, f(r, v, t)") {
  inject<SecondOrder<Fixed>, StruckDamped>(symplectic_euler);
}

TEST_CASE("every call of every scheme, first order in a strided view") {
  inject<FirstOrder<Strided>, Struck>(forward_euler);
}

TEST_CASE("the message names the component, the particle and the term") { check_message(forward_euler); }

TEST_CASE("a state that is not finite is blamed before the force that it spoils") {
  Fault none;
  check_bad_state(Struck{&none}, velocity_verlet), check_bad_state(Struck{&none}, trapezoidal);
}
