/// @file
/// Many particles: states with masses, radii, spins, and forces between all of them or those that are near.
#pragma once

// IWYU pragma: begin_exports

#include "phistep/contacts/contact.hpp"
#include "phistep/contacts/walls.hpp"
#include "phistep/force/external_field.hpp"
#include "phistep/observe/particle_sums.hpp"
#include "phistep/pairs/all_pairs.hpp"
#include "phistep/pairs/pair_laws.hpp"
#include "phistep/pairs/pairs.hpp"
#include "phistep/particles/box.hpp"
#include "phistep/particles/particles.hpp"
#include "phistep/phistep.hpp"
#include "phistep/sleep/sleeping.hpp"
// IWYU pragma: end_exports
