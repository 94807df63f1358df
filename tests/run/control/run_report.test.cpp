#include <phistep/run/control/run_report.hpp>

#include <sstream>

#include "support/catch.hpp"

using namespace phistep;

namespace {
std::string text(const Limits& limits) {
  std::ostringstream out;
  out << limits;
  return out.str();
}
}  // namespace

TEST_CASE("nothing counted: nothing said") {
  const Limits limits;
  CHECK(limits.steps() == 0);
  CHECK(limits.most().by == LimitedBy::nothing);
  CHECK(text(limits).empty());
}

TEST_CASE("the most frequent reason, with its share and its worst component") {
  Limits limits;
  for (int n = 0; n < 71; ++n) limits.count(LimitedBy::error, {1, 3});
  for (int n = 0; n < 20; ++n) limits.count(LimitedBy::error, {1, 4});
  for (int n = 0; n < 9; ++n) limits.count(LimitedBy::stop);
  CHECK(limits.steps() == 100);
  CHECK(limits.most().by == LimitedBy::error);
  CHECK(limits.most().steps == 91);
  CHECK(limits.most().where == Component{1, 3});
  CHECK(text(limits) == "  dt limited by       the error, e.g. of component 3 of block 1, in 91 % of the steps\n");
}

TEST_CASE("a message names the component whose error ruled the run only where errors are why it ended") {
  RunReport report;
  report.limits.count(LimitedBy::error, {0, 3});
  report.outcome = Outcome::stopped_by_event;
  CHECK(report.message().find("component") == std::string::npos);
  report.outcome = Outcome::too_many_steps;
  CHECK(report.message().find("for the error of component 3") != std::string::npos);
}

TEST_CASE("chattering is named where the last steps are short, not where the first were") {
  RunReport report;
  report.outcome = Outcome::too_many_steps;
  report.smallest_dt = 1e-19, report.largest_dt = report.last_dt = 1e-3;
  CHECK(report.message().find("chattering") == std::string::npos);
  report.last_dt = 1e-7;
  CHECK(report.message().find("dt fell from 0.001 to 1e-07") != std::string::npos);
}

TEST_CASE("every reason has a name") {
  const auto only = [](LimitedBy by) {
    Limits limits;
    limits.count(by);
    return text(limits);
  };
  CHECK_THAT(only(LimitedBy::iterations), contains("iterations of the implicit solve, in 100 %"));
  CHECK_THAT(only(LimitedBy::max_step), contains("max_step"));
  CHECK_THAT(only(LimitedBy::stop), contains("times to stop at"));
  CHECK_THAT(only(LimitedBy::not_finite), contains("a force or a state that is not finite"));
}

TEST_CASE("a component that rules more than half of the steps is found, in whatever order they come") {
  Limits limits;
  for (int n = 0; n < 10'001; ++n)
    if (n % 2 == 0) limits.count(LimitedBy::error, {0, 7});
    else limits.count(LimitedBy::error, {0, 100 + n});
  CHECK(limits.most().where == Component{0, 7});
  Limits late;
  for (int n = 0; n < 1000; ++n) late.count(LimitedBy::error, {0, 1});
  for (int n = 0; n < 1001; ++n) late.count(LimitedBy::error, {0, 2});
  for (int n = 0; n < 2000; ++n) late.count(LimitedBy::max_step);
  CHECK(late.most().where == Component{0, 2});
  CHECK(late.most().steps == 2001);
  // Another reason has no component.
  late.count(LimitedBy::max_step), late.count(LimitedBy::max_step);
  CHECK(late.most().by == LimitedBy::max_step);
  CHECK(late.most().where == Component{});
}
