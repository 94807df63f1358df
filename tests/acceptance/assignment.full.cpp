// The assignment of the φ-method's source, by the named schemes. The quick half: assignment.test.cpp.

#include "acceptance/assignment_cases.hpp"

TEST_CASE("assignment: every scheme reaches the closed form, at orders 1 and 2") {
  check_order(phistep::forward_euler, 1, 100);
  check_order(phistep::trapezoidal, 2, 25);
  check_order(phistep::backward_euler, 1, 100);
  check_order(phistep::midpoint, 2, 25);
}

TEST_CASE("assignment: the error is that of the quadrature rule, to its first term") {
  // Sums of h cos(2kh): φ at the end, 1−φ at the start. Error (φ−½) h [g(1) − g(0)] and h²/12 [g'(1) − g'(0)] with
  // g = −B cos(2t) x/(ρC); the next term is O(h) of these.
  constexpr int n = 1000;
  constexpr double h = end / n, scale = HeatedPoints::B / (HeatedPoints::rho * HeatedPoints::C);
  const HeatedPoints::State first = scale * (1 - std::cos(2.0)) * HeatedPoints::points();
  const HeatedPoints::State second = scale * 2 * std::sin(2.0) * HeatedPoints::points();
  const auto error = [](auto scheme) { return (solve(scheme, n) - HeatedPoints::exact(end)).eval(); };
  CHECK(problems::distance(error(phistep::forward_euler), -h / 2 * first) <= 0.01 * (h / 2 * first).norm());
  CHECK(problems::distance(error(phistep::backward_euler), h / 2 * first) <= 0.01 * (h / 2 * first).norm());
  CHECK(problems::distance(error(phistep::trapezoidal), h * h / 12 * second) <= 0.01 * (h * h / 12 * second).norm());
}
