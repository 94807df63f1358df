/// @file
/// What couples to what in ∂Ψ/∂y: decides which matrix exists at all.
#pragma once

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Structure of a tangent.
enum class Structure {
  none,               ///< identically zero: a constant force
  diagonal,           ///< each component depends on itself only: linear drag
  local,              ///< each particle depends on itself only: blocks of a few rows, none beside the diagonal
  network,            ///< pairs of particles that act on each other: springs, pair forces
  block_tridiagonal,  ///< a chain of equal blocks that see their two neighbours
  banded,             ///< nothing far from the diagonal: one-dimensional grids
  dense,              ///< anything may depend on anything
  sparse,             ///< few entries a row: grids, circuits
};

/// The structure of a sum: the least general one that holds both.
[[nodiscard]] constexpr Structure combine(Structure a, Structure b) {
  using enum Structure;
  if (a > b) return combine(b, a);
  if (a == b || b <= network) return b;  // up to here each one holds those before it
  if (a <= diagonal) return b;
  if (b == dense && a != network) return dense;
  return sparse;
}

/// The tangent of a central pair force, B = along n nᵀ + across (I − n nᵀ), n the unit vector from one to the other.
template <class Scalar>
struct PairTangent {
  Scalar along{0}, across{0};
};

}  // namespace phistep::inline PHISTEP_ABI
