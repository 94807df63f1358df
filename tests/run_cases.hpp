#pragma once

// What run.test.cpp and its full half share.

#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "contract/states.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

namespace run_cases {

using namespace phistep;
using problems::distance;
using Vec = Eigen::Vector2d;
using Moving = Motion<Vec>;
using Flow = problems::ForcedFlow<>;
using Swing = problems::ForcedMotion<>;

inline const auto decay = [](const Vec& y) -> Vec { return Vec(-y[0], -2 * y[1]); };
inline Vec decayed(double t) { return {std::exp(-t), std::exp(-2 * t)}; }

inline void for_each_scheme(auto&& f) {
  f("backward_euler", backward_euler), f("phi(0.7)", phi(0.7)), f("trapezoidal", trapezoidal), f("midpoint", midpoint);
  f("tr_bdf2", tr_bdf2), f("forward_euler", forward_euler), f("rannacher", rannacher);
}

}  // namespace run_cases
