// What mass.test.cpp and mass.test.cpp share.
#pragma once

#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace mass_cases {

inline const double NaN = std::nan(""), inf = HUGE_VAL;

/// 50 steps of a damped motion (or 50 of y' = Ψ) under `scheme` with these masses.
template <class Case>
Eigen::VectorXd run(auto scheme, const auto&... masses) {
  Case c;
  auto force = [&] {
    if constexpr (requires { c.state.r; }) return DampedPull{};
    else return DrivenPull{};
  }();
  PhiStepper stepper{c.state, force, scheme, masses...};
  for (int n = 0; n < 50; ++n) REQUIRE(stepper.step(c.state, 0.05 * n, 0.05));
  return numbers(c.state);
}

}  // namespace mass_cases
