// Motions, restarted anywhere: schemes, splits, particles alone, forces with memory. All products, and networks: the
// stress tier, restart_memory.stress.cpp, restart_split.stress.cpp, restart_net.stress.cpp.
#include <phistep/phistep.hpp>

#include "contract/restart.hpp"
#include "contract/restart_motion_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_motion;

#if PHISTEP_FULL

namespace {

/// Of fixed size: half the time to compile that dynamic vectors take.
Motion<states::Fixed> fixed_six() { return states::SecondOrder<states::Fixed>{}.state; }

}  // namespace

TEST_CASE("every scheme of motion restarts to the same bits") {
  // Those of first order, too, are in restart.test.cpp.
  check(uneven, fixed_six, steps(Driven{}, symplectic_euler));
  check(uneven, fixed_six, steps(Driven{}, symplectic_euler_adjoint));
  check(uneven, fixed_six, steps(Driven{}, velocity_verlet));
  check(uneven, fixed_six, steps(Driven{}, phi(0.6, 0.8)));
  check(uneven, fixed_six, steps(Driven{}, tr_bdf2));
  check(uneven, fixed_six, steps(Driven{}, generalized_alpha(0.5)));
}

TEST_CASE("Verlet's carried force knows its time") {
  const Statistics s = check(even, fixed_six, steps(Driven{}, velocity_verlet));
  CHECK(s.force_calls == 61);
}

TEST_CASE("half kicks around an implicit step restart to the same bits") {
  for (const Steps& s : {even, uneven}) {
    const Statistics pull = check(s, fixed_six, steps(Driven{} + at(forward_euler, Pull{}), tr_bdf2));
    CHECK(pull.kick_calls == 61);
  }
}

TEST_CASE("particles alone restart to the same bits") {
  const Statistics affine_each = check(even, crowd, steps(affine(local<3>(Shear{})), trapezoidal));
  CHECK(affine_each.factorizations == 1);
}

TEST_CASE("forces with memory go on with their history") {
  for (const Steps& s : {even, uneven}) check(s, six, steps(Slider{} + Noise{}, velocity_verlet));
}

TEST_CASE("states of the user's own") {
  const auto warm = [] { return states::Coupled{}.state; };
  check(uneven, warm, steps(states::WarmPull{}, forward_euler));
}

#elif PHISTEP_STRESS
// Motions, restarted anywhere: schemes, particles alone.

TEST_CASE("every scheme of motion restarts to the same bits") {
  states::for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    check(uneven, six, steps(states::DampedPull{}, scheme));
    check(even, six, steps(Driven{}, scheme));
  });
}

TEST_CASE("particles alone restart to the same bits") {
  check(uneven, crowd, steps(local<3>(Well{}), tr_bdf2));
  check(uneven, crowd, steps(local<3>(WellWithJacobian{}), phi(0.7), mass(2.0)));
  const Statistics affine_each = check(even, crowd, steps(affine(local<3>(Shear{})), trapezoidal));
  CHECK(affine_each.factorizations == 1);
  check(uneven, crowd, steps(affine(local<3>(Shear{})), trapezoidal));
}

#endif
