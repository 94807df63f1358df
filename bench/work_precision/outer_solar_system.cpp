#include "problems/outer_solar_system.hpp"

#include "motion.hpp"

work_precision::Table work_precision::outer_solar_system() {
  using P = problems::OuterSolarSystem;
  const phistep::Motion start{P::positions(), P::velocities()}, exact{P::exact_positions(), P::exact_velocities()};
  // a: the planets move at 1e-3 to 1e-2 au/day.
  return small_motion<P>("outer_solar_system", "The outer solar system, 200,000 days", start, P::end, exact, 1e-2,
                         1.1e4, 4);
}
