// event_set, every scalar. The quick half is event_set.test.cpp.
#include "observe/event_set_cases.hpp"

using namespace event_set_cases;

TEMPLATE_TEST_CASE("events: a bouncing ball meets every bounce up to the Zeno time, whatever the step", "", float,
                   double, long double) {
  using Scalar = TestType;
  // The formula and the times kept are double.
  const double u = std::max<double>(std::numeric_limits<Scalar>::epsilon(), 0x1p-52) / 2;
  for (const double e : {0.9, 0.5, 0.3, 0.1, 0.01})
    for (const double dt : {0.01, 0.37, 5.0, 1e4}) {
      CAPTURE(e, dt);
      const double drop = std::sqrt(2.0), zeno = drop * (1 + e) / (1 - e);
      auto bounce = event(height, {.direction = Direction::falling},
                          [e](Scalar, Ball<Scalar>& y) { y.v *= -static_cast<Scalar>(e); });
      Ball<Scalar> y = ball<Scalar>(1, 0);
      Loop loop(y, fall<Scalar>, falling<Scalar>, bounce);
      const auto t = static_cast<double>(loop.run(y, 0, 2e4, static_cast<Scalar>(dt)));
      CHECK(loop.outcome == Outcome::events_accumulate);
      // What is left is a geometric series from the first flight that isn't sought any more: 64 probes.
      const double unseen = 64 * 64 * u * zeno;
      CHECK(std::abs(t - zeno) <= unseen / (1 - e) / e + 1e-6 * zeno * (sizeof(Scalar) == 4));
      CHECK(std::abs(static_cast<double>(y.r(0))) <= 64 * u * zeno);
      double at = drop, flight = 2 * drop, k = 1;
      for (const double bounced : bounce.times()) {
        // Each root is known to 16 roundings of t; at the next bounce they count 1/e times, because the ball leaves
        // slowly what it entered fast. Every step before rounds r and v, four roundings in t.
        const double rounding = k * 16 * (2 + 1 / e) + 4 * (at / dt + k);
        REQUIRE(std::abs(bounced - at) <= rounding * u * at);
        flight *= e;
        at += flight;
        ++k;
      }
      CHECK(loop.resteps <= 2 * static_cast<int>(bounce.times().size()));
    }
}
