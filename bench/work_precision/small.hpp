/// @file
/// A few stiff unknowns: dense LU for everybody, fixed-size states for phistep.
#pragma once

#include "first_order.hpp"
#include "phistep_rows.hpp"
#include "sundials_rows.hpp"

namespace work_precision {

template <class S, class Force>
[[nodiscard]] Table small_stiff(std::string name, std::string title, const S& start, const Force& force, double end,
                                const S& exact, double a, int coarsest, int finest) {
  Table table{std::move(name), std::move(title), stacked(exact), a};
  PhistepRows rows{table, start, end, [=](const auto& y, auto scheme) {
                     return phistep::PhiStepper{y, force, scheme};
                   }};
  rows.fixed("backward Euler", phistep::backward_euler, coarsest, finest);
  rows.fixed("trapezoidal", phistep::trapezoidal, coarsest, finest);
  rows.fixed("TR-BDF2", phistep::tr_bdf2, coarsest, finest);
  rows.controlled("TR-BDF2", phistep::tr_bdf2, -6);
  rows.controlled("trapezoidal", phistep::trapezoidal, -6);
  rows.controlled("backward Euler", phistep::backward_euler, -6);
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  sundials::add_implicit(table, FirstOrder<S, Force>{start, force}, end, "dense", sundials::Dense{});
#endif
  return table;
}

}  // namespace work_precision
