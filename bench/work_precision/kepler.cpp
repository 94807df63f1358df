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
  const auto fixed = [&](const char* name, auto scheme, int from, int to) {
    table.methods.push_back(fixed_steps(std::string(name) + ", fixed dt", start, end, steps(end, from, to),
                                        [=](const Kepler::State& y) { return phistep::PhiStepper{y, force, scheme}; }));
  };
  fixed("forward Euler", phistep::forward_euler, 1 << 14, 1 << 21);
  fixed("velocity Verlet", phistep::velocity_verlet, 1 << 9, 1 << 19);
  fixed("trapezoidal", phistep::trapezoidal, 1 << 9, 1 << 17);
#ifdef BENCH_HAS_SUNDIALS_SOLVERS
  sundials::add_explicit(table, FirstOrder<Kepler::State, Kepler>{start, force}, end);
#endif
  return table;
}
