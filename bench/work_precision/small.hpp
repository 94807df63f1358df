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
  const auto fixed = [&](const char* scheme_name, auto scheme, int from, int to) {
    table.methods.push_back(fixed_steps(std::string(scheme_name) + ", fixed dt", start, end, steps(end, from, to),
                                        [=](const S& y) { return phistep::PhiStepper{y, force, scheme}; }));
  };
  fixed("backward Euler", phistep::backward_euler, coarsest, finest);
  fixed("trapezoidal", phistep::trapezoidal, coarsest, finest);
  fixed("TR-BDF2", phistep::tr_bdf2, coarsest, finest);
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  sundials::add_implicit(table, FirstOrder<S, Force>{start, force}, end, "dense", sundials::Dense{});
#endif
  return table;
}

}  // namespace work_precision
