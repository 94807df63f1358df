// The contract of a state, in every shape. The quick half: state.test.cpp.
#include <phistep/phistep.hpp>

#include <cmath>

#include "contract/state_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

TEMPLATE_TEST_CASE("every shape of a first-order state gives the same trajectory", "", Fixed, Columns, FixedColumns,
                   RowMajor, Mapped, Strided, Structs, Reference) {
  check_first_order<TestType>(forward_euler, 0);
}

TEMPLATE_TEST_CASE("every shape of a motion gives the same trajectory", "", Fixed, Columns, FixedColumns, RowMajor,
                   Mapped, Strided, Structs, Reference) {
  check_motion<TestType>(Pull{}, velocity_verlet, 0);
}
