// Four complex matrices at once: each lane as good as pivoted elimination of that matrix alone.
#include "linear/lanes/lane_lu_cases.hpp"

using namespace lane_lu_cases;

TEMPLATE_TEST_CASE("all lanes are solved to rounding, for fixed and dynamic sizes", "", double) {
  check<TestType, 2>(2);
  check<TestType, Eigen::Dynamic>(7);
}

TEST_CASE("a lane that is singular, infinite or NaN is told, whichever it is") {
  for (const int n : {2, 9})
    for (int l = 0; l < lanes; ++l)
      for (const int kind : {0, 1, 2}) {
        CAPTURE(n, l, kind);
        auto W = shifted(n, 5, false, false);
        auto& one = W[static_cast<std::size_t>(l)];
        if (kind == 0) one.row(1) = one.row(0);
        if (kind == 1) one(1, 0) = std::numeric_limits<double>::infinity();
        if (kind == 2) one(1, 1) = std::numeric_limits<double>::quiet_NaN();
        LaneLu<double, Eigen::Dynamic, lanes> lu;
        fill(lu, W);
        CHECK_FALSE((lu.factorize() && kind != 0));
        if (n == 2) {
          LaneLu<double, 2, lanes> fixed;
          fill(fixed, W);
          CHECK_FALSE((fixed.factorize() && kind != 0));
        }
      }
  // Exactly singular where elimination meets an exact zero.
  auto W = shifted(3, 1, false, false);
  W[2].setZero();
  LaneLu<double, 3, lanes> lu;
  fill(lu, W);
  CHECK_FALSE(lu.factorize());
}
