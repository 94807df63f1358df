// A force with memory: its history is a value beside the state, and only an accepted step changes it.
#include "force/memory_cases.hpp"

using namespace memory_cases;

TEST_CASE("one begin and one commit a step, whatever the scheme iterates") {
  for_each_quick_scheme([](const char* name, auto scheme) {
    auto y = start();
    PhiStepper stepper{y, Slider{}, scheme};
    REQUIRE(stepper.memory().commits == 0);
    for (int n = 0; n < 5; ++n) REQUIRE(stepper.step(y, 0.1 * n, 0.1));
    check_fifth(name, stepper.memory());
  });
}

TEST_CASE("commit sees the accepted state") {
  auto y = start();
  PhiStepper stepper{y, Slider{}, trapezoidal};
  const Dynamic anchor = y.r;
  REQUIRE(stepper.step(y, 0, 0.3));
  for (Eigen::Index i = 0; i < 2; ++i)
    CHECK(stepper.memory().anchor[i] == std::clamp(anchor[i], y.r[i] - 0.2, y.r[i] + 0.2));
  CHECK((stepper.memory().anchor != anchor));  // it slipped
}

TEST_CASE("a failed step leaves the history") {
  for_each_quick_scheme([](const char* name, auto scheme) {
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
  PhiStepper stepper{y, Slider{}, velocity_verlet};
  REQUIRE(stepper.step(y, 0, 0.1));
  const Slider::Memory before = stepper.memory();
  const Motion<Vec> kept = y;
  stepper.force().armed = true;
  CHECK_THROWS_AS(stepper.step(y, 0.1, 0.1), std::runtime_error);
  CHECK(same(stepper.memory(), before));
  CHECK((y.r == kept.r && y.v == kept.v));
}

TEST_CASE("history set by value makes a rejected step as if it never was") {
  // An implicit stepper may solve with another Jacobian afterwards, which moves the last bit.
  const auto check = [](auto scheme, double tolerance) {
    auto y = start(), z = start();
    PhiStepper stepper{y, Slider{}, scheme}, never{z, Slider{}, scheme};
    REQUIRE(stepper.step(y, 0, 0.1));
    REQUIRE(never.step(z, 0, 0.1));
    const Slider::Memory checkpoint = stepper.memory();
    const Motion<Vec> kept = y;
    REQUIRE(stepper.step(y, 0.1, 0.4));  // an outer stepper tries, and rejects
    CHECK_FALSE(same(stepper.memory(), checkpoint));
    y = kept;
    stepper.set_memory(checkpoint);
    REQUIRE(stepper.step(y, 0.1, 0.1));
    REQUIRE(never.step(z, 0.1, 0.1));
    CHECK(states::distance(states::numbers(y), states::numbers(z)) <= tolerance);
    CHECK(states::distance(stepper.memory().anchor, never.memory().anchor) <= tolerance);
    CHECK(stepper.memory().commits == never.memory().commits);
  };
  check(velocity_verlet, 0);
  check(trapezoidal, 1e-15);
}

TEST_CASE("a copied stepper has a history of its own") {
  auto y = start();
  PhiStepper stepper{y, Slider{}, velocity_verlet};
  REQUIRE(stepper.step(y, 0, 0.1));
  auto copy = stepper;
  auto z = y;
  REQUIRE(copy.step(z, 0.1, 0.3));
  CHECK(copy.memory().commits == 2);
  CHECK(stepper.memory().commits == 1);
  CHECK((stepper.memory().anchor != copy.memory().anchor));
}

TEST_CASE("in a sum each term keeps its own history") {
  auto y = start();
  PhiStepper stepper{y, Slider{} + LinearDrag{0.1} + Slider{}, forward_euler};
  for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0, 0.2));
  const auto& [first, none, second] = stepper.memory();
  CHECK(same(first, second));
  CHECK(first.commits == 3);
  static_assert(std::is_same_v<std::remove_cvref_t<decltype(none)>, NoMemory>);
}

TEST_CASE("a force without memory remembers nothing") {
  static_assert(!remembers<LinearDrag> && remembers<Slider>);
  static_assert(remembers<Sum<LinearDrag, Slider>> && !remembers<Sum<LinearDrag, Term<states::Pull>>>);
  static_assert(remembers<std::reference_wrapper<Slider>> && remembers<Term<Slider>>);
}
