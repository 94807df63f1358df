// A force with memory: its history is a value beside the state, and only an accepted step changes it.
#include "force/memory_cases.hpp"

using namespace memory_cases;

TEST_CASE("one begin and one commit a step, whatever the scheme iterates") {
  for_each_quick_scheme(begin_and_commit_once);
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

TEST_CASE("a failed step leaves the history") { for_each_quick_scheme(fail_and_keep); }

TEST_CASE("an exception leaves the history") { check_exception(velocity_verlet); }

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

TEST_CASE("in a sum each term keeps its own history") { check_sum(forward_euler); }

TEST_CASE("a force without memory remembers nothing") {
  static_assert(!remembers<LinearDrag> && remembers<Slider>);
  static_assert(remembers<Sum<LinearDrag, Slider>> && !remembers<Sum<LinearDrag, Term<states::Pull>>>);
  static_assert(remembers<std::reference_wrapper<Slider>> && remembers<Term<Slider>>);
}
