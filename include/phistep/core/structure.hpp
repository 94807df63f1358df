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

/// What is known at compile time of the matrix W = M − γ_f C − γ_f γ_d K: enough to choose how to solve with it.
struct MatrixFacts {
  Structure structure = Structure::dense;
  bool has_K = false;        ///< ∂Ψ/∂r is there
  bool has_C = false;        ///< ∂Ψ/∂v (or ∂Ψ/∂y) is there
  bool symmetric = false;    ///< K, C and M are
  bool constant = false;     ///< the force is affine: K and C never change, one factorisation serves many solves
  bool stages = false;       ///< each factorisation serves several solves
  int block = 0;             ///< rows of a particle's or a chain link's block, 0 where there is none
  bool differenced = false;  ///< K and C are made by differences: symmetric, if at all, only to their accuracy
};

/// Whether W is a symmetric sum of pair blocks and of blocks on particles alone.
[[nodiscard]] constexpr bool solves_by_edges(const MatrixFacts& facts) {
  return facts.structure == Structure::network && facts.symmetric && facts.block >= 1 && facts.block <= 3;
}

/// The tangent of a central pair force, B = along n nᵀ + across (I − n nᵀ), n the unit vector from one to the other.
template <class Scalar>
struct PairTangent {
  Scalar along{0}, across{0};
};

}  // namespace phistep::inline PHISTEP_ABI
