// As in_place.test.cpp, in every precision and many more times.
#include "run/stepper/in_place_cases.hpp"

using namespace in_place_cases;

TEST_CASE("in place or beside, many states of all magnitudes end alike") {
  compare_random<double>(11, 400, {2, 3, 9});
  compare_random<double>(12, 10, {600, 1400});
}
TEST_CASE("in place or beside, so do those of other precisions") {
  compare_random<float>(13, 300, {2, 3, 9});
  compare_random<float>(14, 5, {900});
  compare_random<long double>(15, 200, {2, 5});
  compare_random<long double>(16, 3, {500});
}
