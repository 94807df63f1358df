// The contract of a stepper, for every scheme and several kinds of state: all products. The quick half: stepper.test.cpp.
#include <phistep/phistep.hpp>

#include "contract/states.hpp"
#include "contract/stepper_battery.hpp"
#include "contract/stepper_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace {

template <class Case>
void check_explicit_and_implicit() {
  check_contract<Case>(forward_euler, 1);
  check_contract<Case>(trapezoidal, 2);
}

}  // namespace

TEST_CASE("every scheme on a dynamic motion") {
  for_each_motion_scheme(
      [](const char* name, auto scheme) { check_contract<SecondOrder<Dynamic>>(scheme, scheme.order(), name); });
}
TEST_CASE("every first-order scheme on a fixed vector") {
  for_each_first_order_scheme(
      [](const char* name, auto scheme) { check_contract<FirstOrder<Fixed>>(scheme, scheme.order(), name); });
}
TEST_CASE("Verlet on every kind of motion") {
  check_contract<SecondOrder<Fixed>>(velocity_verlet, 2);
  check_contract<SecondOrder<Columns>>(velocity_verlet, 2);
  check_contract<SecondOrder<Strided>>(velocity_verlet, 2);
  check_contract<SecondOrder<Structs>>(velocity_verlet, 2);
}
TEST_CASE("Rannacher's start, and TR-BDF2 on other states") {
  check_contract<SecondOrder<Dynamic>>(rannacher, 2);
  check_contract<FirstOrder<Fixed>>(rannacher(2), 2);
  check_contract<SecondOrder<Strided>>(tr_bdf2, 2);
  check_contract<FirstOrder<RowMajor>>(tr_bdf2, 2);
}
TEST_CASE("halving keeps the contract of what it halves") {
  check_contract<SecondOrder<Dynamic>, false, Halve>(trapezoidal, 2);
  check_contract<SecondOrder<Fixed>, false, Halve>(velocity_verlet, 2);
  check_contract<FirstOrder<Strided>, false, Halve>(tr_bdf2, 2);
  check_contract<FirstOrder<Dynamic>, false, Halve>(rannacher, 2);
}
TEST_CASE("a matrix, a strided view, a reference") {
  check_explicit_and_implicit<FirstOrder<RowMajor>>();
  check_explicit_and_implicit<FirstOrder<Strided>>();
  check_contract<FirstOrder<Reference>>(phi(0.7), 1);
}
