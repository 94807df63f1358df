#pragma once

// Errors in every scalar type: what both halves of convergence/scalars need.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "convergence/observed_order.hpp"
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
