// The same orders in float and in long double as in double, by every scheme. The quick half: scalars.test.cpp.

#include "convergence/scalars_cases.hpp"

namespace {

template <class T>
void check(auto scheme, double order, int n) {
  for (const auto& e : {flow_errors<T>(scheme, n), motion_errors<T>(scheme, n)}) {
    if (std::is_same_v<T, float>) check_float(e);
    convergence::check_order(e, order);
  }
}

}  // namespace

TEMPLATE_TEST_CASE("orders 1 and 2 in every scalar type", "", float, double, long double) {
  check<TestType>(phistep::forward_euler, 1, 100);
  check<TestType>(phistep::backward_euler, 1, 100);
  check<TestType>(phistep::phi(0.25), 1, 100);
  check<TestType>(phistep::phi_stage(0.75), 1, 100);
  check<TestType>(phistep::trapezoidal, 2, 12);
  check<TestType>(phistep::midpoint, 2, 12);
}

TEST_CASE("Verlet is of order 2 in every scalar type") {
  convergence::check_order(
      convergence::errors(12, [](int n) { return motion_error<float>(phistep::velocity_verlet, n); }), 2);
  convergence::check_order(
      convergence::errors(50, [](int n) { return motion_error<long double>(phistep::velocity_verlet, n); }), 2);
}

TEST_CASE("long double steps carry more digits than double") {
  // One trapezoidal step satisfies its formula to the type's own rounding.
  const auto residual = []<class T>(T) {
    using Problem = problems::ForcedFlow<T>;
    const Problem problem;
    auto y = Problem::exact(T{0});
    const auto before = y;
    const T h = T{0.125};
    phistep::PhiStepper stepper{y, problem, phistep::trapezoidal};
    problems::step(stepper, y, T{0}, h);
    return static_cast<double>((y - before - h / 2 * (problem(y, h) + problem(before, T{0}))).cwiseAbs().maxCoeff());
  };
  CHECK(residual(1.0F) <= 4 * static_cast<double>(std::numeric_limits<float>::epsilon()));
  CHECK(residual(1.0) <= 4 * std::numeric_limits<double>::epsilon());
  CHECK(residual(1.0L) <= 4 * static_cast<double>(std::numeric_limits<long double>::epsilon()));
}
