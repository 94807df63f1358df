// Motions, restarted anywhere: forces with memory, states of the user's own, Verlet's carried force. In short:
// restart_motion.test.cpp.
#include <phistep/phistep.hpp>

#include "contract/restart.hpp"
#include "contract/restart_motion_cases.hpp"
#include "contract/states.hpp"
#include "problems/argon.hpp"
#include "problems/forced.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_motion;

TEST_CASE("forces with memory go on with their history") {
  for (const Steps& s : {even, uneven}) {
    check(s, six, steps(Slider{}, backward_euler));
    check(s, six, steps(Slider{}, velocity_verlet));
    check(loosely(s), six, steps(Slider{} + Pull{} + Noise{}, tr_bdf2, tolerant()));
    check(s, six, steps(Slider{} + at(forward_euler, Noise{}), trapezoidal));
  }
  const auto make = [](const auto& y) { return Halving{PhiStepper{y, Slider{} + Noise{}, trapezoidal}, 4}; };
  check(uneven, six, make);
}

TEST_CASE("states of the user's own") {
  const auto warm = [] { return states::Coupled{}.state; };
  check(loosely(uneven), warm, steps(states::WarmPull{}, tr_bdf2, tolerant()));
  check(uneven, warm, steps(states::WarmPull{}, phi(0.7)));
}

TEST_CASE("Verlet's carried force knows its time") {
  const Statistics s = check(even, six, steps(Driven{}, velocity_verlet));
  CHECK(s.force_calls == 61);
  const auto argon = [] { return problems::Argon::start(); };
  const Statistics fixed = check({1e-5}, argon, steps(problems::Argon{}, velocity_verlet, mass(problems::Argon::mass)));
  CHECK(fixed.force_calls == 61);
  const auto start = [] { return problems::ForcedMotion<>::exact(0); };
  check(uneven, start, steps(problems::ForcedMotion<>{}, velocity_verlet));
  check(loosely(uneven), start, steps(problems::ForcedMotion<>{}, tr_bdf2, tolerant()));
  const auto longer = [] { return problems::ForcedMotion<long double>::exact(0); };
  check(loosely(uneven), longer, steps(problems::ForcedMotion<long double>{}, tr_bdf2, tolerant()));
}
