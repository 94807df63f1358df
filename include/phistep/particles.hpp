/// @file
/// Many particles: states with masses, radii, spins, and forces between all of them or those that are near.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/force/external_field.hpp"
#include "phistep/particles/bodies/box.hpp"
#include "phistep/particles/bodies/particle_sums.hpp"
#include "phistep/particles/bodies/particles.hpp"
#include "phistep/particles/contacts/contact.hpp"
#include "phistep/particles/pairs/all_pairs.hpp"
#include "phistep/particles/pairs/pair_laws.hpp"
#include "phistep/particles/pairs/pairs.hpp"
#include "phistep/particles/sleep/sleeping.hpp"
#include "phistep/particles/walls/walls.hpp"
#include "phistep/phistep.hpp"
// IWYU pragma: end_exports
