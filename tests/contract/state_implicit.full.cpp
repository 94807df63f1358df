// The contract of a state under implicit schemes, in every shape, arrays, and a user's own. In short: state.test.cpp.
#include <phistep/phistep.hpp>

#include <cmath>

#include "contract/state_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

TEMPLATE_TEST_CASE("implicit schemes too", "", Fixed, RowMajor, Strided, Reference) {
  check_first_order<TestType>(phi(0.7), 1e-15);
}

TEMPLATE_TEST_CASE("and implicit schemes of damped motion", "", FixedColumns, Columns, Structs) {
  check_motion<TestType>(DampedPull{}, trapezoidal, 2e-15);
}

TEST_CASE("a user's own coupled state: motion and heat in one solve") {
  // Without coupling to T the motion must be that of a plain Motion.
  struct Uncoupled {
    void add(double, const Warm& y, Warm::Rate& out) const {
      for (Eigen::Index k = 0; k < 6; ++k) out.force[k] += pull(y.r[k], y.r[(k + 3) % 6]);
      out.heat -= 2 * y.T;
    }
  };
  const auto check = [](auto scheme, double decay) {
    const Eigen::VectorXd both = run<Coupled>(Uncoupled{}, scheme);
    CHECK(distance(both.head(12), run<SecondOrder<Dynamic>>(Pull{}, scheme)) <= 2e-15);
    CHECK(both[12] == Approx(1.5 * std::pow(decay, 20)).epsilon(1e-12));
    CHECK(both[13] == both[12]);
  };
  check(forward_euler, 1 - 0.2);
  check(trapezoidal, (1 - 0.1) / (1 + 0.1));
  check(midpoint, (1 - 0.1) / (1 + 0.1));
  check(backward_euler, 1 / (1 + 0.2));
}

TEST_CASE("an Eigen array is a state too") {
  Eigen::ArrayXd y = Eigen::ArrayXd::LinSpaced(3, 1, 2);
  Dynamic z = y.matrix();
  PhiStepper a{y, [](const Eigen::ArrayXd& x) -> Eigen::ArrayXd { return -x.cube(); }, trapezoidal,
               mass(Eigen::Vector3d(1, 2, 3))};
  PhiStepper b{z, [](const Dynamic& x) -> Dynamic { return -x.array().cube(); }, trapezoidal,
               mass(Eigen::Vector3d(1, 2, 3))};
  for (int n = 0; n < 10; ++n) REQUIRE((a.step(y, 0, 0.1) && b.step(z, 0, 0.1)));
  CHECK(distance(y.matrix(), z) <= 1e-15);
}
