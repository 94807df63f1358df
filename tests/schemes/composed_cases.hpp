#pragma once

// What the quick and the full half of schemes/composed share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>

#include "contract/states.hpp"
#include "convergence/observed_order.hpp"
#include "problems/driven_motion.hpp"
#include "problems/forced.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;
using Vec = Eigen::VectorXd;

namespace composed_cases {

/// A magnetic field that grows with the distance, perpendicular to the plane, and a pull: no energy is lost.
template <class T>
struct Magnetic {
  using Vector = Eigen::Matrix<T, 2, 1>;
  Vector operator()(const Vector& r, const Vector& v) const {
    const T B = 1 + r.squaredNorm();
    return Vector{-2 * r[0] + B * v[1], -2 * r[1] - B * v[0]};
  }
};
inline Motion<Vec> six() {
  return {Eigen::Map<const Vec>(states::positions.data(), 6), Eigen::Map<const Vec>(states::velocities.data(), 6)};
}
template <class T>
Motion<Eigen::Matrix<T, 2, 1>> two() {
  return {{T(1), T(0.25)}, {T(0), T(0.75)}};
}

}  // namespace composed_cases
