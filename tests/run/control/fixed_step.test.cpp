#include <phistep/run/control/fixed_step.hpp>

#include <array>
#include <cmath>
#include <limits>

#include "support/catch.hpp"

using namespace phistep;

namespace {
/// The grid of a run over a span.
template <class Scalar>
class Grid : public GridPace<Scalar> {
 public:
  Grid(TimeSpan<Scalar> span, const FixedStep& control) : GridPace<Scalar>{control}, outcome_{this->begin(span)} {}
  [[nodiscard]] Outcome outcome() const { return outcome_; }

 private:
  Outcome outcome_;
};
Grid<double> grid(double t0, double t1, double dt, FixedStepOptions options = {}) {
  return {{t0, t1}, fixed(dt, options)};
}
}  // namespace

TEST_CASE("times are t0 + n dt to the bit, and the last is t1") {
  const auto g = grid(0.3, 100.3, 0.1);
  REQUIRE(g.steps() == 1000);
  for (std::int64_t n = 0; n < 1000; ++n) CHECK(g.time(n) == 0.3 + static_cast<double>(n) * 0.1);
  CHECK(g.time(1000) == 100.3);
}

TEST_CASE("a span of whole steps keeps the nominal dt to the end") {
  // 1/0.1, 0.3/0.1, 1.1/0.1 … are not whole in floating point; one factorization a run depends on this.
  for (const double dt : {0.1, 0.01, 0.3, 1.0 / 3, 0.7, 1e-5})
    for (const int n : {1, 2, 3, 7, 10, 11, 100, 999}) {
      const auto g = grid(0, n * dt, dt);
      CAPTURE(dt, n);
      CHECK(g.steps() == n);
      CHECK(g.step(n - 1) == dt);
      CHECK(g.time(n) == n * dt);
    }
}

TEST_CASE("far from t = 0 nothing of a span is lost, and whole steps stay whole") {
  for (const double t0 : {0.0, 5.3, -17.1, 1e3, -1e6, 1.7e9, 1e15})
    for (const double dt : {0.1, 0.01, 0.3, 1.0 / 3, 0.7, 1e-5})
      for (const double sign : {1.0, -1.0})
        for (const double wanted : {0.5, 1.0, 1.45, 2.0, 3.01, 7.0, 100.0, 999.5}) {
          const double t1 = t0 + sign * wanted * dt, length = t1 - t0,
                       spacing = std::nextafter(std::abs(t0) + 1000 * dt, HUGE_VAL) - std::abs(t0) - 1000 * dt;
          const auto g = grid(t0, t1, dt);
          CAPTURE(t0, t1, dt, wanted, sign);
          if (dt < spacing) {
            CHECK((t0 == t1 ? g.outcome() == Outcome::success : g.outcome() == Outcome::step_too_small));
            continue;
          }
          if (length == 0) continue;
          double sum = g.step(g.steps() - 1);
          for (std::int64_t n = 0; n + 1 < g.steps(); ++n) CHECK(g.step(n) == std::copysign(dt, sign));
          sum += static_cast<double>(g.steps() - 1) * std::copysign(dt, sign);
          CHECK(std::abs(sum - length) <= 1e-15 * std::abs(length));
          CHECK(std::abs(g.step(g.steps() - 1)) <= 1.01 * dt);
          CHECK(g.step(g.steps() - 1) * sign > 0);
          CHECK(g.time(g.steps()) == t1);
          // Where the clock is fine enough to tell, whole steps are as many as were meant.
          if (wanted == std::floor(wanted) && 1000 * spacing < dt)
            CHECK(g.steps() == static_cast<std::int64_t>(wanted));
        }
}

TEST_CASE("a step that the clock can't show is refused") {
  CHECK(grid(1.7e9, 1.7e9 + 1, 1e-7).outcome() == Outcome::step_too_small);
  CHECK(grid(1.7e9, 1.7e9 + 1e-3, 1e-5).outcome() == Outcome::success);
  CHECK(grid(-1e16, -1e16 + 100, 1).outcome() == Outcome::step_too_small);
  CHECK(grid(4, 4 - 1e-12, 1e-16).outcome() == Outcome::step_too_small);
  CHECK(Grid<float>({1000.0f, 1001.0f}, fixed(1e-5)).outcome() == Outcome::step_too_small);
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
  CHECK(Grid<float>({0.0f, 1.0f}, fixed(1e-60)).outcome() == Outcome::invalid_step);  // 0 as a float
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
  const Grid<float> g({0.0f, 1000.0f}, fixed(0.1));
  CHECK(g.steps() == 10000);
  CHECK(g.time(9999) == 9999.0f * 0.1f);
  CHECK(g.time(10000) == 1000.0f);
}

TEST_CASE("a negative dt over a span that runs forward is refused, over one that runs backward both signs serve") {
  const auto refused = grid(0, 1, -0.1);
  CHECK(refused.outcome() == Outcome::invalid_step);
  CHECK(refused.steps() == 0);
  for (const double dt : {0.1, -0.1}) {
    const auto back = grid(1, 0, dt);
    CHECK(back.outcome() == Outcome::success);
    CHECK(back.steps() == 10);
    CHECK(back.step(0) == -0.1);
  }
  CHECK(grid(0, 1, 0.1).outcome() == Outcome::success);
}

TEST_CASE("frames of whole steps have as many steps as at t = 0, wherever they lie") {
  for (const double t0 : {0.0, 0.3, 5.0, 1000.0, 1e6})
    for (int k = 0; k < 600; ++k) {
      const Grid<double> grid{{t0 + k / 60.0, t0 + (k + 1) / 60.0}, fixed(1.0 / 240)};
      CAPTURE(t0, k);
      CHECK(grid.steps() == 4);
    }
}
