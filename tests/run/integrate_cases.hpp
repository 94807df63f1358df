#pragma once

// What integrate.test.cpp and its full half share.

#include <phistep/integrate.hpp>
#include <phistep/phistep.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "support/catch.hpp"

namespace integrate_cases {

using namespace phistep;
using Vec = Eigen::Vector2d;
using Y = Motion<Vec>;

inline const auto spring = [](const Vec& r) -> Vec { return -4 * r; };
inline Y start() { return {Vec(1, 0), Vec(0, 0.5)}; }
inline const auto decay = [](const Vec& y, double t) -> Vec { return (-y.array() + t).matrix(); };

}  // namespace integrate_cases
