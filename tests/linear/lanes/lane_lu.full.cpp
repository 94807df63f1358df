// lane_lu: the full product and what is dear to compile. The quick half is lane_lu.test.cpp.
#include "linear/lanes/lane_lu_cases.hpp"

using namespace lane_lu_cases;

TEMPLATE_TEST_CASE("all lanes are solved to rounding, for fixed and dynamic sizes", "", float, double, long double) {
  check<TestType, 1>(1);
  check<TestType, 2>(2);
  check<TestType, 3>(3);
  check<TestType, 6>(6);
  check<TestType, 9>(9);  // LU from here on
  check<TestType, 20>(20);
  check<TestType, Eigen::Dynamic>(7);
}
