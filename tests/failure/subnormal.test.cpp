// What decays goes on to decay where its numbers become subnormal, and then stays at nothing: no step fails. Every
// scheme and solver: the full tier.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>

#include "support/catch.hpp"

namespace subnormal_cases {

using namespace phistep;
template <class T>
using Three = Eigen::Matrix<T, 3, 1>;

struct Cubic {
  template <class T>
  Three<T> operator()(const Three<T>& x) const {
    return T(-0.7) * x - T(0.1) * x.array().cube().matrix();
  }
};

/// Steps until nothing but some of the least numbers is left, and on.
template <class S, class F, class... Options>
void check(const char* name, S y, F f, Options... options) {
  using T = ScalarOf<S>;
  PhiStepper stepper{y, f, options...};
  INFO(name);
  int steps = 0;
  for (; steps < 6000; ++steps) {
    const StepReport report = stepper.step(y, static_cast<T>(0.5) * static_cast<T>(steps), static_cast<T>(0.5));
    if (!report) FAIL("step " << steps << ": " << report.message());
  }
  double largest = 0;
  for_each_block(
      [&](auto, const auto& block) { largest = std::max(largest, static_cast<double>(block.cwiseAbs().maxCoeff())); },
      Blocks<S>::all(y));
  CHECK(largest <= 30 * static_cast<double>(std::numeric_limits<T>::denorm_min()));
}

}  // namespace subnormal_cases

using namespace subnormal_cases;

#if PHISTEP_QUICK

TEST_CASE("a decay to nothing is stepped to its end") {
  const Three<double> y(1, 0.5, 2);
  check("trapezoidal", y, Cubic{}, trapezoidal);
  check("rodas4", y, Cubic{}, rodas4);
  check("radau", y, Cubic{}, radau);
  check("fixed point", y, Cubic{}, phi(0.6), fixed_point());
}

#elif PHISTEP_FULL
// A decay to nothing: every kind of scheme and of solver, motions, float.

TEMPLATE_TEST_CASE("a decay to nothing is stepped to its end: first order", "", double, float) {
  using T = TestType;
  using V = Eigen::Matrix<T, Eigen::Dynamic, 1>;
  const Three<T> y(1, T(0.5), 2);
  check("backward_euler", y, Cubic{}, backward_euler);
  check("tr_bdf2", y, Cubic{}, tr_bdf2);
  check("rannacher", y, Cubic{}, rannacher);
  check("midpoint", y, Cubic{}, midpoint);
  check("fixed point, plain", y, Cubic{}, phi(0.6), fixed_point({.depth = 0}));
  check("affine", y, linear(Eigen::Matrix<T, 3, 3>(Eigen::Matrix<T, 3, 3>::Identity() * T(-0.7))), trapezoidal);
  const auto chain = [](const V& x) -> V {
    V f = T(-0.9) * x;
    f.tail(x.size() - 1) += T(0.2) * x.head(x.size() - 1);
    return f;
  };
  const V z = V::LinSpaced(8, 1, 2);
  check("rodas5p", z, chain, rodas5p);
  check("linearly implicit", z, chain, backward_euler, linearly_implicit());
  check("banded", z, banded(chain, 1, 0), tr_bdf2);
  check("to a tolerance", z, chain, trapezoidal, newton({.rtol = 1e-4, .atol = 0}));
  check("fixed point to a tolerance", z, chain, phi(0.6), fixed_point({.rtol = 1e-4, .atol = 0}));
}

TEMPLATE_TEST_CASE("a decay to nothing is stepped to its end: motions", "", double, float) {
  using T = TestType;
  const auto damped = [](const Three<T>& r, const Three<T>& v) -> Three<T> { return -r - T(0.8) * v; };
  const Motion<Three<T>> y{Three<T>(1, T(0.5), 2), Three<T>(1, 0, -1)};
  check("trapezoidal", y, damped, trapezoidal);
  check("backward_euler", y, damped, backward_euler);
  check("tr_bdf2", y, damped, tr_bdf2);
  check("midpoint", y, damped, midpoint);
  check("velocity_verlet", y, damped, velocity_verlet);
  check("rodas4", y, damped, rodas4);
  check("radau", y, damped, radau);
  check("fixed point", y, damped, phi(0.6), fixed_point());
}

#endif
