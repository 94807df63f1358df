// Motions, restarted anywhere: schemes, particles alone. The quick half: restart_motion.test.cpp.
#include <phistep/phistep.hpp>

#include "contract/restart.hpp"
#include "contract/restart_motion_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_motion;

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
