// The contract of a stepper, for schemes of high order. More states: high_order.full.cpp.
#include <phistep/phistep.hpp>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

TEST_CASE("linear stages") { check_contract<FirstOrder<Fixed>>(rodas4, 4); }
TEST_CASE("explicit Runge-Kutta") {
  check_contract<FirstOrder<Fixed>>(tsit5, 5);
  check_contract<SecondOrder<Fixed>>(dop853, 8);
}
TEST_CASE("explicit motion") {
  check_contract<SecondOrder<Fixed>>(srkn11b, 6);
  check_contract<SecondOrder<Fixed>>(rkn86, 8);
  check_contract<SecondOrder<Fixed>>(composed(velocity_verlet), 8);
}
TEST_CASE("Radau") { check_contract<FirstOrder<Fixed>>(radau, 5); }
