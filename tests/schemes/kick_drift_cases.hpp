#pragma once

// What the quick and the full half of schemes/kick_drift share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>

#include "contract/states.hpp"
#include "convergence/observed_order.hpp"
#include "problems/driven_motion.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::error_at_end;
using problems::march;
using Vec = Eigen::VectorXd;

namespace kick_drift_cases {

struct Anharmonic : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(auto, const auto& y, auto& out) const { out.force -= 2 * y.r + y.r.cwiseProduct(y.r).cwiseProduct(y.r); }
};
struct LateTrouble : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = true;
  void add(double t, const auto& y, auto& out) const {
    out.force -= y.r;
    if (t > 0.15) out.force[3] = std::numeric_limits<double>::quiet_NaN();
  }
};
inline Motion<Vec> six() {
  return {Eigen::Map<const Vec>(states::positions.data(), 6), Eigen::Map<const Vec>(states::velocities.data(), 6)};
}

}  // namespace kick_drift_cases
