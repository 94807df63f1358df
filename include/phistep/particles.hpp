/// @file
/// Many particles: states with masses, radii, spins, and forces between all of them or those that are near.
#pragma once

// IWYU pragma: begin_exports
#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include "phistep/particles/bodies/body.hpp"           // Box: periodic or open axes
#include "phistep/particles/bodies/particle_sums.hpp"  // temperature, pressure, momenta, energies
#include "phistep/particles/bodies/particles.hpp"      // Particles: the state
#include "phistep/particles/contacts/contact.hpp"      // Contact: grains with friction
#include "phistep/particles/pairs/all_pairs.hpp"       // AllPairs: gravity, charges, laws without a cutoff
#include "phistep/particles/pairs/pair_laws.hpp"       // LennardJones and other laws
#include "phistep/particles/pairs/pairs.hpp"           // Pairs: a law up to a cutoff
#include "phistep/particles/sleep/sleeping.hpp"        // Sleeping: bodies at rest are left out
#include "phistep/particles/walls/walls.hpp"           // planes and solid boxes
#include "phistep/phistep.hpp"                         // states, steppers, schemes, the loop
// IWYU pragma: end_exports
