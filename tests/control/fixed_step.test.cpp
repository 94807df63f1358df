#include <phistep/control/fixed_step.hpp>

#include <array>
#include <cmath>
#include <limits>

#include "support/catch.hpp"

using namespace phistep;

namespace {
TimeGrid<double> grid(double t0, double t1, double dt, FixedStepOptions options = {}) {
  return TimeGrid<double>({t0, t1}, fixed(dt, options));
}
}  // namespace

TEST_CASE("times are t0 + n dt to the bit, and the last is t1") {
  const auto g = grid(0.3, 100.3, 0.1);
  REQUIRE(g.steps() == 1000);
  for (std::int64_t n = 0; n < 1000; ++n) CHECK(g.time(n) == 0.3 + static_cast<double>(n) * 0.1);
  CHECK(g.time(1000) == 100.3);
}

TEST_CASE("a span of whole steps keeps the nominal dt to the end") {
  // 1/0.1, 0.3/0.1, 1.1/0.1 … are not whole in floating point; one factorisation a run depends on this.
  for (const double dt : {0.1, 0.01, 0.3, 1.0 / 3, 0.7, 1e-5})
    for (const int n : {1, 2, 3, 7, 10, 11, 100, 999})
      for (const double t0 : {0.0, 5.3, -17.1}) {
        const auto g = grid(t0, t0 + n * dt, dt);
        CAPTURE(dt, n, t0);
        CHECK(g.steps() == n);
        CHECK(g.step(n - 1) == dt);
        CHECK(g.time(n) == t0 + n * dt);
      }
}

TEST_CASE("what is left over is one shorter step") {
  const auto g = grid(0, 1, 0.3);
  CHECK(g.steps() == 4);
  CHECK(g.step(0) == 0.3);
  CHECK(g.step(2) == 0.3);
  CHECK(g.step(3) == Approx(0.1));
  CHECK(g.time(3) + g.step(3) == Approx(1).epsilon(1e-15));
  const auto one = grid(0, 1, 5);  // shorter than one step
  CHECK(one.steps() == 1);
  CHECK(one.step(0) == 1);
}

TEST_CASE("a span that runs backward is stepped backward, whatever the sign of dt") {
  for (const double dt : {0.3, -0.3}) {
    const auto g = grid(2, 1, dt);
    CHECK(g.steps() == 4);
    CHECK(g.step(0) == -0.3);
    CHECK(g.step(3) == Approx(-0.1));
    CHECK(g.time(1) == 2 - 0.3);
    CHECK(g.time(4) == 1);
  }
  CHECK(grid(0, 1, -0.5).step(0) == 0.5);
}

TEST_CASE("an empty span has no steps and is no failure") {
  const auto g = grid(3, 3, 0.1);
  CHECK(g.steps() == 0);
  CHECK(g.outcome() == Outcome::success);
  CHECK(g.time(0) == 3);
}

TEST_CASE("numbers that can't be stepped with are refused") {
  const double NaN = std::nan(""), inf = HUGE_VAL;
  for (const auto& [t0, t1, dt] : {std::array{NaN, 1.0, 0.1}, std::array{0.0, NaN, 0.1}, std::array{0.0, 1.0, NaN},
                                   std::array{0.0, inf, 0.1}, std::array{-inf, 0.0, 0.1}, std::array{0.0, 1.0, inf},
                                   std::array{0.0, 1.0, 0.0}, std::array{-1.7e308, 1.7e308, 1e300}}) {
    CAPTURE(t0, t1, dt);
    CHECK(grid(t0, t1, dt).outcome() == Outcome::invalid_step);
    CHECK(grid(t0, t1, dt).steps() == 0);
  }
  CHECK(TimeGrid<float>({0.0f, 1.0f}, fixed(1e-60)).outcome() == Outcome::invalid_step);  // 0 as a float
}

TEST_CASE("the step cap holds exactly") {
  CHECK(grid(0, 1, 0.1, {.max_steps = 10}).steps() == 10);
  CHECK(grid(0, 1, 0.1, {.max_steps = 9}).outcome() == Outcome::too_many_steps);
  CHECK(grid(0, 1, 0.3, {.max_steps = 4}).steps() == 4);
  CHECK(grid(0, 1, 0.3, {.max_steps = 3}).outcome() == Outcome::too_many_steps);
  CHECK(grid(0, 1, 1e-300).outcome() == Outcome::too_many_steps);
  for (int n = 1; n < 2000; ++n) {  // n·dt/dt may round to just above n
    CAPTURE(n);
    CHECK(grid(0, n * 0.1, 0.1, {.max_steps = n}).steps() == n);
    CHECK(grid(0, n * 0.7, 0.7, {.max_steps = n}).steps() == n);
  }
}

TEST_CASE("float time does not drift") {
  const TimeGrid<float> g({0.0f, 1000.0f}, fixed(0.1));
  CHECK(g.steps() == 10000);
  CHECK(g.time(9999) == 9999.0f * 0.1f);
  CHECK(g.time(10000) == 1000.0f);
}
