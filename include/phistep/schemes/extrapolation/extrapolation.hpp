/// @file
/// Extrapolated schemes, as types: steps of variable order made of many steps of a simple one.
#pragma once

#include <stdexcept>
#include <string>

#include "phistep/core/phi.hpp"
#include "phistep/core/scheme_facts.hpp"
#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Richardson's extrapolation of a base scheme: the error's expansion in powers of the substep is eliminated term by term.
/// @tparam Base  the scheme of the substeps
template <class Base>
struct Extrapolated {
  static constexpr SchemeFacts facts{.motion_only = Base::facts.motion_only,
                                     .is_explicit = Base::facts.is_explicit,
                                     .is_symplectic = false,
                                     .is_a_stable = false,
                                     .is_l_stable = false,
                                     .energy = EnergyBalance::rest};
  [[nodiscard]] static std::string name() {
    std::string name = "extrapolated(";
    return name.append(Base::name()).append(1, ')');
  }
  [[no_unique_address]] Base base;
  int columns = 0;  ///< of each step, 0: as many as the error asks for
};

template <class Scheme>
inline constexpr bool is_extrapolated = false;
template <class Base>
inline constexpr bool is_extrapolated<Extrapolated<Base>> = true;

/// Columns that a table has room for, and that a step without error control takes.
inline constexpr int most_columns = 12, usual_columns = 4;

/// A scheme of variable order, made of the results of many short steps of a simple one:
///
///     extrapolated(forward_euler)     not stiff: Gragg's rule, order 2j in column j of the table
///     extrapolated(velocity_verlet)   motion whose force ignores v: order 2j
///     extrapolated(backward_euler)    stiff, linearly implicit: order j; deprecated in double precision
///
/// extrapolated(backward_euler) reports successes that are wrong: near an equilibrium of components of very different size,
/// the table magnifies the roundings of its columns, and the error estimate, a difference of two entries that share them,
/// does not see it. On E5 (Hairer & Wanner's test set) the end at t = 1e5 is off by 430 rtol at rtol 1e-10, and at t = 1e11
/// by more than the solution itself at every rtol from 1e-2 to 1e-11. Take rodas5p or radau.
///
/// @param columns  of every step; left out, the error chooses them (without error control: usual_columns)
/// @throws std::invalid_argument where columns is negative or more than most_columns
template <class Base>
[[nodiscard]] constexpr Extrapolated<Base> extrapolated(Base base, int columns = 0) {
  if (columns < 0 || columns > most_columns)
    throw std::invalid_argument("phistep: extrapolated(scheme, columns) needs 1 <= columns <= 12");
  return {base, columns};
}

}  // namespace phistep::inline PHISTEP_ABI
