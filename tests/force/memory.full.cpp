// memory: the full product and what is dear to compile. The quick half is memory.test.cpp.
#include "force/memory_cases.hpp"

using namespace memory_cases;

TEST_CASE("one begin and one commit a step, whatever the scheme iterates") {
  states::for_each_motion_scheme(begin_and_commit_once);
}

TEST_CASE("a failed step leaves the history") { states::for_each_motion_scheme(fail_and_keep); }

TEST_CASE("an exception leaves the history") { check_exception(backward_euler); }

TEST_CASE("two runs from the same state and history agree to the bit") {
  const auto run = [] {
    auto y = start();
    PhiStepper stepper{y, Slider{} + LinearDrag{0.1}, velocity_verlet};
    for (int n = 0; n < 50; ++n) REQUIRE(stepper.step(y, 0.05 * n, 0.05));
    return y;
  };
  const auto a = run(), b = run();
  CHECK((a.r == b.r && a.v == b.v));
}

TEST_CASE("in a sum each term keeps its own history") { check_sum(trapezoidal); }
