#pragma once

// What iteration_control.test.cpp and its full half share.

#include <phistep/control/iteration_control.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/catch.hpp"

namespace iteration_cases {

using namespace phistep;
using One = Eigen::Matrix<double, 1, 1>;
using Swing = Motion<One>;
using Two = Eigen::Vector2d;

inline Failure contracting(int corrections, double q) {
  Failure history;
  for (int k = 0; k < corrections; ++k) history.record(0.3 * std::pow(q, k));
  return history;
}

/// m r'' = −ω² r, by plain iteration.
struct Pull {
  double omega_squared;
  auto operator()(const auto& r) const { return (-omega_squared * r).eval(); }
};

}  // namespace iteration_cases
