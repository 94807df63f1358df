// block_tridiagonal_lu: the full product and what is dear to compile. The quick half is block_tridiagonal_lu.test.cpp.
#include "linear/block_tridiagonal_lu_cases.hpp"

using namespace block_tridiagonal_lu_cases;

TEMPLATE_TEST_CASE("solves chains of blocks", "", Size<1>, Size<2>, Size<3>, Size<5>, Size<17>) {
  check_chains<TestType::value>();
}

TEMPLATE_TEST_CASE("what it accepts it solves to three quarters of the digits at least, dominant or not", "", Size<1>,
                   Size<2>, Size<3>) {
  check_accepted<TestType::value>();
}
