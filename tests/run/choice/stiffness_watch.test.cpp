#include "phistep/run/choice/stiffness_watch.hpp"

#include <limits>

#include "support/catch.hpp"

using phistep::RateSeen;
using phistep::StiffnessWatch;

namespace {
constexpr double never = std::numeric_limits<double>::infinity();
/// Looks until the watch says that an implicit scheme should take over; 0: not within ten.
int looks_until_stiff(const RateSeen& seen) {
  // dop853 beside radau on a few unknowns
  StiffnessWatch watch{{.bound = 6, .explicit_cost = 12, .implicit_cost = 40}};
  for (int n = 1; n <= 10; ++n)
    if (watch.judge(seen)) return n;
  return 0;
}
}  // namespace

TEST_CASE("explicit steps at their bound of stability are left, sooner where y' hardly changes") {
  CHECK(looks_until_stiff({.rate = 5, .dt = 1, .left = 1000, .change = 0.1}) == 2);
  CHECK(looks_until_stiff({.rate = 5, .dt = 1, .left = 1000, .change = 1}) == 3);
  CHECK(looks_until_stiff({.rate = 2, .dt = 1, .left = 1000, .change = 0.1, .smooth_step = 4}) == 0);
  CHECK(looks_until_stiff({.rate = 5, .dt = 1, .left = 5, .change = 0.1}) == 0);  // the run ends before that pays
}

TEST_CASE("explicit steps well within it are left where y' would allow much longer ones") {
  const RateSeen held{.rate = 2, .dt = 1, .left = 1000, .change = 0.2, .smooth_step = 20};
  CHECK(looks_until_stiff(held) == 3);
  const auto with = [&held](auto&& change) {
    RateSeen seen = held;
    change(seen);
    return looks_until_stiff(seen);
  };
  CHECK(with([](RateSeen& s) { s.smooth_step = 4; }) == 0);  // the error of y itself holds Δt
  CHECK(with([](RateSeen& s) { s.rate = 1; }) == 0);         // no mode is fast beside Δt
  CHECK(with([](RateSeen& s) { s.turn = -1; }) == 0);        // it oscillates
  CHECK(with([](RateSeen& s) { s.left = 10; }) == 0);        // too late to pay
  CHECK(with([](RateSeen& s) { s.smooth_step = never; }) == 3);
}

TEST_CASE("implicit steps are left where explicit ones of the same length would do, four looks in a row") {
  StiffnessWatch watch{{.bound = 6, .explicit_cost = 12, .implicit_cost = 40}};
  watch.begin_implicit();
  for (int n = 1; n <= 3; ++n) CHECK_FALSE(watch.judge({.rate = 1, .dt = 1, .left = 100}));
  CHECK_FALSE(watch.judge({.rate = 100, .dt = 1, .left = 100}));
  for (int n = 1; n <= 3; ++n) CHECK_FALSE(watch.judge({.rate = 1, .dt = 1, .left = 100}));
  CHECK(watch.judge({.rate = 1, .dt = 1, .left = 100}));
}

TEST_CASE(
    "decays that would take more explicit steps than forty implicit ones cost begin implicit, oscillations don't") {
  const StiffnessWatch watch{{.bound = 6, .explicit_cost = 12, .implicit_cost = 40}};
  CHECK(watch.starts_stiff({.rate = 1, .dt = 0.01, .left = 1000}, true));  // 167 steps
  CHECK_FALSE(watch.starts_stiff({.rate = 1, .dt = 0.01, .left = 500}, true));
  CHECK_FALSE(watch.starts_stiff({.rate = 1, .dt = 0.01, .left = 1e6, .turn = 0}, true));
  CHECK_FALSE(watch.starts_stiff({.rate = 1, .dt = 0.01, .left = 1e6}, false));
  CHECK(watch.starts_stiff({.rate = 1, .dt = 40, .left = 500}, false));  // the error allows 40 times the limit
}
