#pragma once

// What the quick and the full half of schemes/rannacher share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>

#include "contract/states.hpp"
#include "convergence/observed_order.hpp"
#include "problems/forced.hpp"
#include "problems/heat.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::march;
using Vec = Eigen::VectorXd;

namespace rannacher_cases {

inline constexpr int points = 799;
inline constexpr double end = 0.1;

inline Vec step_data() {
  Vec u(points);
  for (int i = 0; i < points; ++i) u[i] = std::abs((i + 1.0) / (points + 1) - 0.5) < 0.25 ? 1 : 0;
  return u;
}
inline Vec point_source() {
  Vec u = Vec::Zero(points);
  u[points / 2] = points + 1;
  return u;
}
}  // namespace rannacher_cases
