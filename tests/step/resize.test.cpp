// What may change between two steps besides numbers: a parameter, the number of components, the stepper's owner.
#include "step/resize_cases.hpp"

using namespace resize_cases;

// One implicit type: a stepper of dynamic vectors takes seconds to compile.
namespace {
struct Elastic {
  double k;
  Dynamic operator()(const Dynamic& r) const { return -k * r; }
};
}  // namespace

TEST_CASE("a step that was interrupted by an exception leaves nothing stale") {
  bool fail = false;
  const auto check_scheme = [&](auto scheme) {
    SecondOrder<Dynamic> a, b;
    PhiStepper stepper{a.state, Interrupted{&fail}, scheme};
    PhiStepper never{b.state, Interrupted{&fail}, scheme};
    for (int n = 0; n < 10; ++n) {
      fail = true;
      CHECK_THROWS_AS(stepper.step(a.state, 0.1 * n, 0.2), std::runtime_error);
      fail = false;
      REQUIRE(stepper.step(a.state, 0.1 * n, 0.1));
      REQUIRE(never.step(b.state, 0.1 * n, 0.1));
      CHECK(distance(numbers(a.state), numbers(b.state)) <= 1e-13);
    }
  };
  check_scheme(velocity_verlet);
}

TEST_CASE("a parameter changed through force() takes effect at once") {
  const auto check_scheme = [](auto scheme) {
    SecondOrder<Dynamic> a;
    PhiStepper stepper{a.state, Elastic{1}, scheme};
    REQUIRE(stepper.step(a.state, 0, 0.1));
    SecondOrder<Dynamic> b;
    b.state = a.state;
    stepper.force().k = 50;
    PhiStepper fresh{b.state, Elastic{50}, scheme};
    REQUIRE(stepper.step(a.state, 0.1, 0.1));
    REQUIRE(fresh.step(b.state, 0.1, 0.1));
    CHECK(distance(numbers(a.state), numbers(b.state)) <= 1e-14);
  };
  check_scheme(velocity_verlet), check_scheme(phi(0.7));
}

TEST_CASE("reset changes no result") {
  const auto check_scheme = [](auto scheme, double tolerance) {
    SecondOrder<Dynamic> a, b;
    PhiStepper one{a.state, Elastic{2}, scheme}, two{b.state, Elastic{2}, scheme};
    for (int n = 0; n < 20; ++n) {
      two.reset();
      REQUIRE((one.step(a.state, 0, 0.1) && two.step(b.state, 0, 0.1)));
    }
    CHECK(distance(numbers(a.state), numbers(b.state)) <= tolerance);
  };
  check_scheme(velocity_verlet, 0), check_scheme(phi(0.7), 1e-13);
}

// ---- the number of components may change between steps --------------------------------------------------------------

TEST_CASE("a dynamic state may grow and shrink between steps") {
  const auto check_scheme = [](auto scheme) {
    Motion<Dynamic> y{Dynamic::Ones(2), Dynamic::Zero(2)};
    PhiStepper stepper{y, Elastic{2}, scheme};
    for (const Eigen::Index size : {2, 5, 5, 1, 8, 2}) {
      y.r = Dynamic::LinSpaced(size, 1, 2), y.v = Dynamic::Zero(size);
      auto z = y;
      PhiStepper fresh{z, Elastic{2}, scheme};
      REQUIRE(stepper.step(y, 0, 0.1));
      REQUIRE(fresh.step(z, 0, 0.1));
      CHECK(distance(numbers(y), numbers(z)) <= 1e-14);
    }
  };
  check_scheme(velocity_verlet), check_scheme(phi(0.7));
}

TEST_CASE("a mass per component does not fit a resized state: it throws, every time, and leaves the state") {
  const auto check_scheme = [](auto scheme) {
    Dynamic y = Dynamic::Ones(2);
    PhiStepper stepper{y, Pull{}, scheme, mass(Eigen::Vector2d(1, 2))};
    REQUIRE(stepper.step(y, 0, 0.1));
    y = Dynamic::Ones(3);
    for (int k = 0; k < 2; ++k) CHECK_THROWS_AS(stepper.step(y, 0, 0.1), std::invalid_argument);
    CHECK(y == Dynamic::Ones(3));
    y = Dynamic::Ones(2);
    CHECK(stepper.step(y, 0, 0.1));
  };
  check_scheme(forward_euler);
}

TEST_CASE("growing beyond what dense differences can do throws every time") {
  Motion<Dynamic> y{Dynamic::Ones(2), Dynamic::Ones(2)};
  PhiStepper stepper{y, Elastic{1}, phi(0.7)};
  REQUIRE(stepper.step(y, 0, 0.1));
  y.r = y.v = Dynamic::Ones(1001);
  for (int k = 0; k < 2; ++k) CHECK_THROWS_AS(stepper.step(y, 0, 0.1), std::invalid_argument);
  CHECK(y.r == Dynamic::Ones(1001));
  y.r = y.v = Dynamic::Ones(3);
  CHECK(stepper.step(y, 0, 0.1));
}

TEST_CASE("a motion whose r and v differ in size throws, at construction and later") {
  Motion<Dynamic> y{Dynamic::Ones(3), Dynamic::Ones(2)};
  CHECK_THROWS_AS((PhiStepper{y, Elastic{1}, forward_euler}), std::invalid_argument);
  y.v = Dynamic::Ones(3);
  PhiStepper stepper{y, Elastic{1}, velocity_verlet};
  y.v = Dynamic::Ones(4);
  CHECK_THROWS_AS(stepper.step(y, 0, 0.1), std::invalid_argument);
}

TEST_CASE("an empty state is stepped without complaint") {
  Motion<Dynamic> y{Dynamic(0), Dynamic(0)};
  CHECK(PhiStepper{y, Elastic{-1}, phi(0.7)}.step(y, 0, 0.1));
}

// ---- copies ---------------------------------------------------------------------------------------------------------

TEST_CASE("a copy of a stepper shares nothing with the original") {
  const auto run = [](bool disturb) {
    Motion<Dynamic> y{Dynamic::LinSpaced(4, 0.1, 0.2), Dynamic::Ones(4)};
    PhiStepper stepper{y, Elastic{3}, phi(0.7)};
    for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0, 0.01));
    auto copy = std::make_unique<decltype(stepper)>(stepper);
    if (disturb) {
      Motion<Dynamic> z{Dynamic::LinSpaced(4, 1, 2), Dynamic::Ones(4)};
      REQUIRE(copy->step(z, 0, 0.3));
      copy.reset();
    }
    const Statistics before = stepper.statistics();
    for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(y, 0, 0.01));
    return std::pair{y, stepper.statistics() - before};
  };
  const auto disturbed = run(true), alone = run(false);
  CHECK(same_bits(numbers(disturbed.first), numbers(alone.first)));
  CHECK(disturbed.second == alone.second);
}
