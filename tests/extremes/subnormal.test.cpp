// What decays goes on to decay where its numbers become subnormal, and then stays at nothing: no step fails. Every scheme and
// solver: subnormal.full.cpp.
#include "extremes/subnormal_cases.hpp"

using namespace subnormal_cases;

TEST_CASE("a decay to nothing is stepped to its end") {
  const Three<double> y(1, 0.5, 2);
  check("trapezoidal", y, Cubic{}, trapezoidal);
  check("rodas4", y, Cubic{}, rodas4);
  check("radau", y, Cubic{}, radau);
  check("fixed point", y, Cubic{}, phi(0.6), fixed_point());
}
