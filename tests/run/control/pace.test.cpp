// The length that a run takes next, from what a pace was told of the steps so far.
#include <phistep/base/state/motion.hpp>
#include <phistep/run/control/pace.hpp>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace {

const TimeSpan<double> span{0, 10};
const Vec start = Vec::Ones(2);
bool decay(double, const Vec& y, Vec& out) { return out = -y, true; }

template <class Pace>
Pace begun(Pace pace) {
  REQUIRE(pace.begin(start, ErrorLaw{}) == Outcome::success);
  REQUIRE(pace.start(span, start, 1, decay) == Outcome::success);
  return pace;
}

}  // namespace

TEST_CASE("a step cut short by a time to stop at says nothing of the next: the length is that of before") {
  const SolveRecord quick;  // converged at once
  const auto check = [&](auto pace) {
    REQUIRE(pace.propose() == 0.5);
    Limits limits;
    for (const double cut : {1e-2, 1e-9}) {
      pace.accepted({.end = cut, .dt = cut, .lands = true, .clipped = true}, quick, limits);
      CHECK(pace.propose() == 0.5);
      CHECK(limits.most().by == LimitedBy::stop);
    }
    // Only slightly cut, it may have been short for its error: the next one is longer.
    pace.accepted({.end = 0.45, .dt = 0.45, .lands = true, .clipped = true}, quick, limits);
    CHECK(pace.propose() > 0.5);
    CHECK(pace.propose() <= 2.5);
  };
  check(begun(ErrorPace<Vec>{tolerance{.rtol = 1e-4, .first_step = 0.5}}));
  check(begun(ErrorPace<Vec>{smaller_of(tolerance{.rtol = 1e-4, .first_step = 0.5}, iteration_control{})}));
  check(begun(IterationPace<Vec>{iteration_control{.first_step = 0.5}}));
}
