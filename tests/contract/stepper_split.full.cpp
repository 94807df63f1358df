// The contract of a stepper whose scene is split: all of it. In short: stepper.test.cpp.
#include <phistep/phistep.hpp>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

TEST_CASE("a split scene: trouble in the kicks, trouble in the rest") {
  const auto kicks = [](Moody moody) { return term(Pull{}) + at(forward_euler, moody); };
  const auto rest = [](Moody moody) { return at(forward_euler, Pull{}) + term(moody); };
  check_contract<SecondOrder<Dynamic>>(trapezoidal, 2, kicks);
  check_contract<SecondOrder<Dynamic>>(trapezoidal, 2, rest);
  check_contract<SecondOrder<Strided>>(tr_bdf2, 2, kicks);
  check_contract<SecondOrder<Columns>>(velocity_verlet, 2, kicks);
  check_contract<FirstOrder<Fixed>>(midpoint, 2, kicks);
  check_contract<FirstOrder<Dynamic>>(backward_euler, 1, kicks);
}

TEST_CASE("slow terms: trouble among them, trouble in the inner steps") {
  const auto slow = [](Moody moody) { return term(Pull{}) + seldom(4, moody); };
  const auto fast = [](Moody moody) { return seldom(2, Pull{}) + term(moody) + seldom(4, Pull{}); };
  check_contract<SecondOrder<Dynamic>>(velocity_verlet, 2, slow);
  check_contract<SecondOrder<Dynamic>>(velocity_verlet, 2, fast);
  check_contract<SecondOrder<Strided>>(velocity_verlet, 2, slow);
  check_contract<SecondOrder<Columns>>(symplectic_euler, 1, fast);
  check_contract<SecondOrder<Fixed>>(symplectic_euler_adjoint, 1, slow);
}
