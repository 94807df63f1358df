#pragma once

// What the tests of automatic runs share.

#include <phistep/automatic.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "problems/robertson.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

namespace automatic_cases {

using namespace phistep;
using problems::Robertson;
using Vec = Eigen::Vector2d;

inline const auto slow = [](const Vec& y) -> Vec { return {-y[0], -2 * y[1]}; };

/// y'' = μ (1 − y²) y' − y: stiff on its slow branches, not stiff in its jumps.
struct Oscillator {
  double mu;
  Vec operator()(const Vec& y) const { return {y[1], mu * (1 - y[0] * y[0]) * y[1] - y[0]}; }
};

/// The run by one scheme, picked by hand.
template <class S>
RunReport by_hand(S& y, const auto& force, auto scheme, TimeSpan<double> span, const tolerance& wanted) {
  PhiStepper stepper{y, force, scheme};
  return integrate(stepper, y, span, wanted);
}

}  // namespace automatic_cases
