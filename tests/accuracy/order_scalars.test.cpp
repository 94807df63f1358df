// The same orders in float and in long double as in double. Every scheme: the stress tier.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "accuracy/observed_order.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"

namespace {

template <class T>
double flow_error(auto scheme, int n) {
  using Problem = problems::ForcedFlow<T>;
  const auto y = Problem::exact(T{0});
  phistep::PhiStepper stepper{y, Problem{}, scheme, phistep::capacity(Problem::capacity)};
  return problems::distance(problems::march(stepper, y, T{0}, T{2}, n), Problem::exact(T{2}));
}
template <class T>
double motion_error(auto scheme, int n) {
  using Problem = problems::ForcedMotion<T>;
  const auto y = Problem::exact(T{0});
  phistep::PhiStepper stepper{y, Problem{}, scheme, phistep::mass(Problem::mass)};
  return problems::distance(problems::march(stepper, y, T{0}, T{2}, n), Problem::exact(T{2}));
}

// In float, an error of 1e-5 is still mostly the scheme's: n = 1000 roundings of 6e-8 walk 2e-6.
constexpr double float_floor = 1e-5;

[[maybe_unused]] void check_float(const std::array<double, 4>& e) {
  REQUIRE(*std::min_element(e.begin(), e.end()) > float_floor);
}
template <class T>
std::array<double, 4> flow_errors(auto scheme, int n) {
  return convergence::errors(n, [&](int steps) { return flow_error<T>(scheme, steps); });
}
template <class T>
std::array<double, 4> motion_errors(auto scheme, int n) {
  return convergence::errors(n, [&](int steps) { return motion_error<T>(scheme, steps); });
}

}  // namespace

#if PHISTEP_FULL

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

#elif PHISTEP_STRESS
// The same orders in float and in long double as in double, by every scheme.

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

#endif
