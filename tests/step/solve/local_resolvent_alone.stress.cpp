// Each particle alone and among others, by every scheme; in short: local_resolvent.test.cpp.
#include <phistep/autodiff.hpp>

#include "step/solve/local_resolvent_cases.hpp"

using namespace local_resolvent_cases;

TEST_CASE("each particle takes its own iterations and gets the bits that it has alone") {
  SECTION("with a Jacobian") { check_alone_and_among_others(local<3>(WellWithJacobian{}), trapezoidal); }
  SECTION("by differences") { check_alone_and_among_others(local<3>(Well{}), trapezoidal); }
  SECTION("by automatic differentiation") {
    const auto force = autodiff([](const auto& r, const auto& v) {
      return typename std::remove_cvref_t<decltype(r)>(-r - r.squaredNorm() * r - 0.2 * v);
    });
    check_alone_and_among_others(local<3>(force), trapezoidal);
  }
  SECTION("backward Euler") { check_alone_and_among_others(local<3>(WellWithJacobian{}), backward_euler); }
  SECTION("stage form") { check_alone_and_among_others(local<3>(WellWithJacobian{}), midpoint); }
  SECTION("phi = 0.7, which carries the force") { check_alone_and_among_others(local<3>(Well{}), phi(0.7)); }
  SECTION("Gravity and LinearDrag beside it") {
    check_alone_and_among_others(local<3>(WellWithJacobian{}) + Gravity{Vector3d(0, 0, -1)} + LinearDrag{0.5},
                                 trapezoidal, mass(2.0));
  }
}
