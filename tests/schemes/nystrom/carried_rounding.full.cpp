// Compensated sums: restarts; the quick half is carried_rounding.test.cpp.
#include "contract/restart.hpp"

#include "schemes/nystrom/carried_rounding_cases.hpp"

using namespace carried_rounding_cases;

TEST_CASE("compensated sums: what was lost belongs to that state alone") {
  auto y = six();
  PhiStepper used{y, Anharmonic{}, compensated(rkn86)};
  for (int n = 0; n < 10; ++n) problems::step(used, y, 0.1 * n, 0.1);
  auto other = six();
  other.v *= 1e-200;
  auto same = other;
  PhiStepper fresh{same, Anharmonic{}, compensated(rkn86)};
  problems::step(used, other, 0.0, 0.1);
  problems::step(fresh, same, 0.0, 0.1);
  CHECK(restart::bytes(other) == restart::bytes(same));
}

TEST_CASE("a restart gives the same bits") {
  const auto steps = [](auto scheme) {
    return [=](const auto& y) { return PhiStepper{y, Anharmonic{}, scheme, mass(2.0)}; };
  };
  restart::check({0.05, false}, six, steps(rkn86));
  restart::check({0.05}, six, steps(compensated(rkn1210)));
}
