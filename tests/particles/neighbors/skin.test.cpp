#include <phistep/particles/neighbors/neighbor_list.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/catch.hpp"

using namespace phistep;

namespace {
constexpr double unbounded = std::numeric_limits<double>::infinity();
}  // namespace

TEST_CASE("a skin grows where lists cost more than what they hold, and shrinks where they hold more than they cost") {
  const double longer = 0.2 * std::sqrt(2.0), shorter = 0.2 / std::sqrt(2.0);
  CHECK(next_skin<3>(1.0, 0.2, {0.1, 1, 4}, unbounded) == Approx(longer));       // a gas
  CHECK(next_skin<3>(1.0, 0.2, {80, 400, 1000}, unbounded) == Approx(shorter));  // a crystal
  // p L = 100, and (b + q T)/m = 46: a rung more costs +38 and -9, a rung less -19 and +17 (and less than 3 % is not worth it).
  CHECK(next_skin<3>(1.0, 0.2, {100, 400, 12}, unbounded) == 0.2);
}

TEST_CASE("a skin has bounds") {
  CHECK(next_skin<3>(1.0, 1.5, {0, 0, 1}, unbounded) == 1.5);            // two cutoffs
  CHECK(next_skin<3>(1.0, 0.2, {0, 0, 1}, 0.25) == 0.2);                 // a small box
  CHECK(next_skin<3>(1.0, 0.08, {80, 400, 100000}, unbounded) == 0.08);  // 0.06 cutoffs
}

TEST_CASE("from wherever a skin starts, it ends at the same width, within a rung") {
  // A gas of 0.05 in a cube of the cutoff's side, whose fastest particle takes 40 steps for a cutoff.
  const auto settle = [](double skin) {
    for (int list = 0; list < 40; ++list) {
      const double volume = std::pow(1 + skin, 3);
      skin = next_skin<3>(1.0, skin, {0.2 * volume, 1.1 * volume, std::max(1, static_cast<int>(40 * skin))}, unbounded);
    }
    return skin;
  };
  const double from_short = settle(0.1), from_long = settle(1.9);
  CHECK(from_short > 0.5);
  CHECK(from_short / from_long < 1.5);
  CHECK(from_long / from_short < 1.5);
}
