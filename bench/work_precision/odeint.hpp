/// @file
/// What Odeint's rows share. Odeint gets the problems' own types, so that it can inline them.
#pragma once

#include <boost/numeric/odeint.hpp>
#include <cstddef>
#include <vector>

#include "table.hpp"

namespace work_precision::boost_odeint {

namespace odeint = boost::numeric::odeint;

/// Odeint never gives up by itself.
constexpr long most_calls = 5000000;
struct TooMany {};

/// To the end; where there is a film, stopping at its times: not all of these steppers interpolate.
template <class Stepper, class F, class State>
std::size_t integrate(const Stepper& stepper, const F& f, State& y, double end, double first, Film* film) {
  if (!film) return odeint::integrate_adaptive(stepper, f, y, 0.0, end, first);
  std::vector<double> times{0.0};
  times.insert(times.end(), film->times.begin(), film->times.end());
  std::size_t k = 0;
  return odeint::integrate_times(stepper, f, y, times.begin(), times.end(), first, [&](const State& now, double) {
    if (k++ > 0) film->put(k - 2, &now[0]);
  });
}

void add_stiff(Table& table);
void add_motion(Table& table);

}  // namespace work_precision::boost_odeint
