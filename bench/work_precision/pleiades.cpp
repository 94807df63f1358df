#include "problems/pleiades.hpp"

#include "motion.hpp"

work_precision::Table work_precision::pleiades() {
  using P = problems::Pleiades;
  const phistep::Motion start{P::positions(), P::velocities()}, exact{P::exact_positions(), P::exact_velocities()};
  return small_motion<P>("pleiades", "Pleiades, seven stars", start, P::end, exact, 1.0, 1.2e3, 4);
}
