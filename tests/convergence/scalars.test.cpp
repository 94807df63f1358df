// The same orders in float and in long double as in double. Every scheme: scalars.stress.cpp.

#include "convergence/scalars_cases.hpp"

TEST_CASE("orders 1 and 2 in every scalar type") {
  const auto in_float = motion_errors<float>(phistep::trapezoidal, 12);
  check_float(in_float);
  convergence::check_order(in_float, 2);
  convergence::check_order(flow_errors<long double>(phistep::trapezoidal, 12), 2);
}

TEST_CASE("Verlet is of order 2 in every scalar type") {
  convergence::check_order(
      convergence::errors(12, [](int n) { return motion_error<float>(phistep::velocity_verlet, n); }), 2);
}

TEST_CASE("long double steps carry more digits than double") {
  // One trapezoidal step satisfies its formula to the type's own rounding.
  using T = long double;
  using Problem = problems::ForcedFlow<T>;
  const Problem problem;
  auto y = Problem::exact(T{0});
  const auto before = y;
  const T h = T{0.125};
  phistep::PhiStepper stepper{y, problem, phistep::trapezoidal, phistep::capacity(1.0)};
  problems::step(stepper, y, T{0}, h);
  const T residual = (y - before - h / 2 * (problem(y, h) + problem(before, T{0}))).cwiseAbs().maxCoeff();
  CHECK(residual <= 4 * std::numeric_limits<T>::epsilon());
}
