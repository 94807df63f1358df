#include "problems/kepler.hpp"

#include "first_order.hpp"
#include "phistep_rows.hpp"
#include "sundials_rows.hpp"

work_precision::Table work_precision::kepler() {
  using problems::Kepler;
  const Kepler force;
  constexpr double end = 5 * Kepler::period;
  const Kepler::State start = force.start();
  Table table{"kepler", "Kepler, e = 0.6, five periods", stacked(force.exact(end)), 1.0};
  PhistepRows rows{table, start, end, [=](const auto& y, auto scheme) {
                     return phistep::PhiStepper{y, force, scheme};
                   }};
  rows.fixed("forward Euler", phistep::forward_euler, 1 << 14, 1 << 21);
  rows.fixed("velocity Verlet", phistep::velocity_verlet, 1 << 9, 1 << 19);
  rows.fixed("trapezoidal", phistep::trapezoidal, 1 << 9, 1 << 17);
  rows.controlled("velocity Verlet", phistep::velocity_verlet, -7);
  rows.controlled("trapezoidal", phistep::trapezoidal, -7);
  rows.controlled("TR-BDF2", phistep::tr_bdf2, -7);
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  sundials::add_explicit(table, FirstOrder<Kepler::State, Kepler>{start, force}, end);
#endif
  return table;
}
