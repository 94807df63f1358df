#pragma once

// Boost.Odeint on such a problem. Odeint of Boost 1.74 is no C++20: odeint.cpp is C++17, and meets the rest at the linker.

#include "accuracy/truth/problem.hpp"

namespace truth {

/// rosenbrock4 (which is RODAS), with the Jacobian and the controller that come with it.
[[nodiscard]] Answer odeint_rosenbrock4(const Problem& problem, double rtol);
/// runge_kutta_dopri5, controlled
[[nodiscard]] Answer odeint_dopri5(const Problem& problem, double rtol);

}  // namespace truth
