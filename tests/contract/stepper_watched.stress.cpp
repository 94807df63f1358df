// Steps that are watched are the steps, for every scheme of motions. In short: stepper.test.cpp.
#include <phistep/phistep.hpp>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "contract/stepper_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

TEST_CASE("a watched step is the step, a rejected one is none: every scheme on motions") {
  for_each_motion_scheme([](const char* name, auto scheme) {
    check_watched<SecondOrder<Dynamic>>(scheme, dynamic_pull, name);
    check_watched<SecondOrder<Dynamic>>(scheme, damped_pull, name);
    check_watched_trouble<SecondOrder<Dynamic>>(scheme, name);
  });
  check_watched<Coupled>(trapezoidal, WarmPull{});
  check_watched<Coupled>(tr_bdf2, WarmPull{});
  check_watched<Coupled>(velocity_verlet, WarmPull{});
}
