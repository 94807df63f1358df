/// @file
/// Which masses an equation can't have.
#pragma once

#include <stdexcept>
#include <string>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/non_finite.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/mass/bound_masses.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Of m v' = Ψ, the first block solved for: ½ vᵀMv is an energy, > 0 wherever v ≠ 0. Numbers were checked where they were given,
/// but for zeros. Blocks beside it, such as temperatures, have a regular M.
/// @throws std::invalid_argument
void refuse_masses_of_motion(const auto& masses) {
  if (const Offender at = algebraic_component(masses))
    throw std::invalid_argument("phistep: a mass of motion must be > 0, and a mass matrix invertible: component " +
                                std::to_string(at.index));
  for_each_block(
      [](auto k, const auto& mass) {
        if constexpr (k == 0 && requires { mass.is_positive_definite(); })
          if (!mass.is_positive_definite())
            throw std::invalid_argument(
                "phistep: a mass matrix of motion must be symmetric and positive definite, as 1/2 v^T M v is an "
                "energy");
      },
      masses);
}

/// Of M y' = Ψ, where the scheme or its solver needs M⁻¹.
/// @throws std::invalid_argument
void refuse_singular_masses(const auto& masses, const std::string& scheme) {
  if (const Offender at = algebraic_component(masses))
    throw std::invalid_argument(
        "phistep: M is singular (component " + std::to_string(at.index) + " of block " + std::to_string(at.block) +
        " is algebraic) and " + scheme +
        ", or its solver, needs its inverse: take rodas4, rodas5p, tr_bdf2 or backward_euler with newton()");
}

}}  // namespace phistep::PHISTEP_ABI
