// The contract of a state: every scalar. In short: state.test.cpp.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "contract/state_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;
using namespace states;

TEMPLATE_TEST_CASE("float, double and long double take the same steps, each to its precision", "", float, double,
                   long double) {
  using V = Eigen::Matrix<TestType, 2, 1>;
  using D = Eigen::Matrix<TestType, Eigen::Dynamic, 1>;
  const auto oscillator = []<class Vector>(std::type_identity<Vector>, auto scheme) {
    Motion<Vector> y{Vector(2), Vector(2)};
    y.r << 1, 2, y.v << 0, 0;
    const shared_force::OfState<Vector> force = [](const Vector& r) -> Vector { return -r; };
    PhiStepper stepper{y, force, scheme, mass(2)};
    for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(y, static_cast<TestType>(n) / 10, TestType(1) / 10));
    // Energy ½·2v² + ½r²: φ = ½ keeps it.
    return static_cast<double>(y.v.squaredNorm() + y.r.squaredNorm() / 2);
  };
  const double u = static_cast<double>(std::numeric_limits<TestType>::epsilon());
  CHECK(std::abs(oscillator(std::type_identity<V>{}, trapezoidal) - 2.5) <= std::max(1000 * u, 1e-15));
  CHECK(std::abs(oscillator(std::type_identity<D>{}, midpoint) - 2.5) <= std::max(1000 * u, 1e-15));
  CHECK(std::abs(oscillator(std::type_identity<V>{}, velocity_verlet) - 2.5) <= 2e-3);
}
