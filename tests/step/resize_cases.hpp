#pragma once

// What the quick and the full half of step/resize share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace resize_cases {
/// Throws when told to, with its force half written.
struct Interrupted {
  static constexpr bool uses_velocity = false, uses_time = false;
  const bool* fail;
  void add(double, const auto& y, auto& out) const {
    out.force[0] -= 2 * y.r[0];
    if (*fail) throw std::runtime_error("force");
    for (Eigen::Index i = 1; i < y.r.size(); ++i) out.force[i] -= 2 * y.r[i];
  }
};
}  // namespace resize_cases
