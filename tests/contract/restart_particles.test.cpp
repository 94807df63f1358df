// Particles, restarted anywhere: neighbour lists go on as they would have. Histories, sleepers, more schemes and forces:
// restart_particles.full.cpp.
#include <phistep/particles.hpp>

#include "contract/restart.hpp"
#include "contract/restart_particles_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace restart_particles;

TEST_CASE("neighbour lists come back as they were") {
  check({.dt = 0.005, .count = 120}, gas, steps(lennard_jones(), velocity_verlet));
}
