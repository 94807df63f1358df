// Motions, with and without velocities in the force.
#include "problems/damped_pendulum.hpp"
#include "problems/driven_chain.hpp"
#include "problems/kepler.hpp"
#include "problems/outer_solar_system.hpp"
#include "problems/pleiades.hpp"
#include "problems/van_der_pol.hpp"

#include "rows.hpp"

void automatic::motions() {
  using namespace problems;
  using phistep::Motion;
  const Kepler kepler;
  const double two = 2 * Kepler::period;
  measure(problem("Kepler, e = 0.6", kepler.start(), kepler, two, stacked(kepler.exact(two)), 1.0));
  const Motion stars{Pleiades::positions(), Pleiades::velocities()},
      end{Pleiades::exact_positions(), Pleiades::exact_velocities()};
  measure(problem("Pleiades", stars, Pleiades{}, Pleiades::end, stacked(end), 1.0));
  using Planets = OuterSolarSystem;
  const Motion planets{Planets::positions(), Planets::velocities()},
      later{Planets::exact_positions(), Planets::exact_velocities()};
  measure(problem("outer solar system", planets, Planets{}, Planets::end, stacked(later), 1e-2));
  measure(problem("damped pendulum", DampedPendulum::start(), DampedPendulum{}, DampedPendulum::end,
                  stacked(DampedPendulum::exact()), 1.0));
  measure(problem("Van der Pol as a motion, mu = 5", VanDerPol::start(), VanDerPol{}, VanDerPol::end,
                  stacked(VanDerPol::exact()), 1.0));
  measure(problem("driven chain", DrivenChain::start(), DrivenChain{}, DrivenChain::end, stacked(DrivenChain::exact()),
                  1.0));
}
