// banded_lu: the full product and what is dear to compile. The quick half is banded_lu.test.cpp.
#include "linear/banded/banded_lu_cases.hpp"

using namespace banded_lu_cases;

TEMPLATE_TEST_CASE("solves A x = b for any band, where rows must change places too", "", float, double, long double) {
  check_any_band<TestType>();
}
