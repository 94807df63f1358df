// memory: the full product and what is dear to compile. The quick half is memory.test.cpp.
#include "force/memory_cases.hpp"

using namespace memory_cases;

TEST_CASE("one begin and one commit a step, whatever the scheme iterates") {
  states::for_each_motion_scheme([](const char* name, auto scheme) {
    auto y = start();
    PhiStepper stepper{y, Slider{}, scheme};
    REQUIRE(stepper.memory().commits == 0);
    for (int n = 0; n < 5; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
    check_fifth(name, stepper.memory());
  });
}

TEST_CASE("a failed step leaves the history") {
  states::for_each_motion_scheme([](const char* name, auto scheme) {
    auto y = start();
    PhiStepper stepper{y, Slider{}, scheme};
    REQUIRE(stepper.step(y, 0, 0.1));
    const Slider::Memory before = stepper.memory();
    y.v[1] = 1e3;
    stepper.force().poison = 0.01;  // the start is out of bounds already
    CAPTURE(name);
    CHECK_FALSE(stepper.step(y, 0.1, 0.1));
    CHECK(same(stepper.memory(), before));
    CHECK_FALSE(stepper.step(y, 0.1, std::nan("")));
    CHECK(same(stepper.memory(), before));
  });
}

TEST_CASE("an exception leaves the history") {
  auto y = start();
  PhiStepper stepper{y, Slider{}, backward_euler};
  REQUIRE(stepper.step(y, 0, 0.1));
  const Slider::Memory before = stepper.memory();
  const Motion<Vec> kept = y;
  stepper.force().armed = true;
  CHECK_THROWS_AS(stepper.step(y, 0.1, 0.1), std::runtime_error);
  CHECK(same(stepper.memory(), before));
  CHECK((y.r == kept.r && y.v == kept.v));
}

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

TEST_CASE("in a sum each term keeps its own history") {
  auto y = start();
  PhiStepper stepper{y, Slider{} + LinearDrag{0.1} + Slider{}, trapezoidal};
  for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0, 0.2));
  const auto& [first, none, second] = stepper.memory();
  CHECK(same(first, second));
  CHECK(first.commits == 3);
  static_assert(std::is_same_v<std::remove_cvref_t<decltype(none)>, NoMemory>);
}
