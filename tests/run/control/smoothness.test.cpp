#include "phistep/step/transaction/trace.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using phistep::Smoothness;

namespace {
[[nodiscard]] double smooth(double dt) { return std::pow(7 * dt, 8); }   // the square of an error that goes as Δt⁴
[[nodiscard]] double jumping(double dt) { return std::pow(7 * dt, 2); }  // Δt
}  // namespace

TEST_CASE("errors that go as Δt^k are those of a smooth force, whatever Δt does") {
  Smoothness known;
  for (const double dt : {1.0, 0.2, 0.19, 0.001, 0.002, -3.0}) {
    CHECK(known.holds(smooth(dt), dt, 4));
    if (dt < 0.1) known.accepted();
  }
}

TEST_CASE("errors that fall as Δt, try after try, are not, until a step is accepted") {
  Smoothness known;
  CHECK(known.holds(jumping(1), 1, 4));
  CHECK(known.holds(jumping(0.6), 0.6, 4));  // 4.6 times what Δt⁴ leaves
  CHECK_FALSE(known.holds(jumping(0.25), 0.25, 4));
  CHECK_FALSE(known.holds(jumping(0.24), 0.24, 4));  // as against the last that was smooth
  known.accepted();
  CHECK(known.holds(jumping(0.24), 0.24, 4));
}

TEST_CASE("an error that comes from one step to the next") {
  for (const auto& [growth, expected] : {std::pair{290.0, true}, std::pair{310.0, false}}) {
    Smoothness known;
    CHECK(known.holds(smooth(1), 1, 4));
    known.accepted();
    CHECK(known.holds(growth * growth * smooth(0.5), 0.5, 4) == expected);
    known.forget();
    CHECK(known.holds(growth * growth * smooth(0.5), 0.5, 4));
  }
}

TEST_CASE("after an error of zero nothing is known, and no length of a step overflows") {
  Smoothness known;
  CHECK(known.holds(0, 1, 4));
  CHECK(known.holds(1, 1, 4));
  CHECK(known.holds(std::pow(1e-70, 8), 1e-70, 8));
  CHECK(known.holds(1, 1e300, 12));
}
