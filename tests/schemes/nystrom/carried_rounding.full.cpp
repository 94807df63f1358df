// Compensated sums: restarts; the quick half is carried_rounding.test.cpp.
#include "contract/restart.hpp"

#include "schemes/nystrom/carried_rounding_cases.hpp"

using namespace carried_rounding_cases;

TEST_CASE("a restart gives the same bits") {
  const auto steps = [](auto scheme) {
    return [=](const auto& y) { return PhiStepper{y, Anharmonic{}, scheme, mass(2.0)}; };
  };
  restart::check({0.05, false}, six, steps(rkn86));
  restart::check({0.05}, six, steps(compensated(rkn1210)));
}
