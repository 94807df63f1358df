// A decay to nothing: every kind of scheme and of solver, motions, float. The quick half is subnormal.test.cpp.
#include "extremes/subnormal_cases.hpp"

using namespace subnormal_cases;

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
