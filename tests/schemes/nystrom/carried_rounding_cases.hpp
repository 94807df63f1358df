#pragma once

// What the quick and the full half of schemes/nystrom/carried_rounding share.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>

#include "contract/states.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace carried_rounding_cases {

struct Anharmonic : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(auto, const auto& y, auto& out) const { out.force -= 2 * y.r + y.r.cwiseProduct(y.r).cwiseProduct(y.r); }
};
inline Motion<Vec> six() {
  return {Eigen::Map<const Vec>(states::positions.data(), 6), Eigen::Map<const Vec>(states::velocities.data(), 6)};
}

}  // namespace carried_rounding_cases
