/// @file
/// Extrapolated schemes, as types: steps of variable order made of many steps of a simple one.
#pragma once

#include <stdexcept>

#include "phistep/core/phi.hpp"
#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Richardson's extrapolation of a base scheme: the error's expansion in powers of the substep is eliminated term by term.
/// @tparam Base  the scheme of the substeps
template <class Base>
struct Extrapolated {
  static constexpr bool is_pair = Base::is_pair;
  static constexpr bool is_explicit = Base::is_explicit;
  [[no_unique_address]] Base base;
  int columns = 0;  ///< of each step, 0: as many as the error asks for
};

/// Columns that a table has room for, and that a step without error control takes.
inline constexpr int most_columns = 12, usual_columns = 4;

/// extrapolated(backward_euler)    stiff equations, linearly implicit: order j in column j
/// extrapolated(forward_euler)     Gragg's rule: order 2j in column j
/// extrapolated(velocity_verlet)   motion whose force ignores v: order 2j
/// @param columns  of every step; left out, the error chooses them (without error control: usual_columns)
/// @throws std::invalid_argument where columns is negative or more than most_columns
template <class Base>
[[nodiscard]] constexpr Extrapolated<Base> extrapolated(Base base, int columns = 0) {
  if (columns < 0 || columns > most_columns)
    throw std::invalid_argument("phistep: extrapolated(scheme, columns) needs 1 <= columns <= 12");
  return {base, columns};
}

}  // namespace phistep::inline PHISTEP_ABI
