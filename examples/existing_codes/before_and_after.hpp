/// @file
/// The three codes of this folder as they were (`before::Cloth`, `before::MolecularDynamics`, `before::HeatPlate`) and
/// embedded (`after::…`), in one program.
#pragma once

#define CODE before
#include "heat.hpp"
#include "mass_spring.hpp"
#include "molecular_dynamics.hpp"
#undef CODE

#define WITH_PHISTEP
#define CODE after
#include "heat.hpp"
#include "mass_spring.hpp"
#include "molecular_dynamics.hpp"
#undef CODE
#undef WITH_PHISTEP
