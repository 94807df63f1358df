// Steps of first-order states that are watched are the steps, for every scheme. In short: stepper.test.cpp.
#include <phistep/phistep.hpp>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "contract/stepper_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

TEST_CASE("a watched step is the step, a rejected one is none: every scheme on first-order states") {
  for_each_first_order_scheme([](const char* name, auto scheme) {
    check_watched<FirstOrder<Fixed>>(scheme, DrivenPull{}, name);
    check_watched<FirstOrder<Strided>>(scheme, ForceOf<FirstOrder<Strided>>(Pull{}), name);
    check_watched_trouble<FirstOrder<Dynamic>>(scheme, name);
  });
  check_watched<FirstOrder<RowMajor>>(tr_bdf2, Pull{});
  check_watched<FirstOrder<Columns>>(phi(0.7), Pull{});
  check_watched<SecondOrder<Structs>>(velocity_verlet, Pull{});
  check_watched<SecondOrder<Fixed>>(velocity_verlet, DampedPull{});
}
