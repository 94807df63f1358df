#include <phistep/control/limits.hpp>

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
  CHECK(limits.most().by == LimitedBy::nobody);
  CHECK(text(limits).empty());
}

TEST_CASE("the most frequent reason, with its share") {
  Limits limits;
  for (int n = 0; n < 71; ++n) limits.count(LimitedBy::error, {1, 3});
  for (int n = 0; n < 20; ++n) limits.count(LimitedBy::error, {1, 4});
  for (int n = 0; n < 9; ++n) limits.count(LimitedBy::stop);
  CHECK(limits.steps() == 100);
  CHECK(limits.most().steps == 71);
  CHECK(limits.most().where == Component{1, 3});
  CHECK(text(limits) == "  dt limited by       the error of component 3 of block 1, in 71 % of the steps\n");
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

TEST_CASE("in bounded memory, whatever is frequent enough is found") {
  // Space saving with m = 8 slots: a reason of more than a share 1/m is never lost, its count too large by n/m at most.
  Limits limits;
  std::int64_t often = 0, n = 0;
  for (; n < 10'000; ++n) {
    if (n % 3 == 0) limits.count(LimitedBy::error, {0, 7}), ++often;
    else limits.count(LimitedBy::error, {0, 100 + n});
  }
  CHECK(limits.most().where == Component{0, 7});
  CHECK(limits.most().steps >= often);
  CHECK(limits.most().steps <= often + n / 8);
  CHECK(limits.steps() == n);
}
