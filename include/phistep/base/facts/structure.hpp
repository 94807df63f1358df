/// @file
/// Which unknowns couple in ∂Ψ/∂y: this decides what kind of matrix a solve makes, if any.
#pragma once

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Structure of a tangent.
enum class Structure {
  none,      ///< identically zero: a constant force
  diagonal,  ///< each component depends on itself only: linear drag
  local,     ///< each particle depends on itself only: blocks of a few rows, none beside the diagonal
  network,   ///< pairs of particles that act on each other: springs, pair forces
  banded,    ///< nothing far from the diagonal: one-dimensional grids and chains
  dense,     ///< anything may depend on anything
  sparse,    ///< few entries a row: grids, circuits
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
/// entry(row, column, x) for ∂f_i/∂r_j = B and the other three blocks that Newton's third law makes of it.
/// @param B  (a, b) ↦ a number of the dim × dim block
template <int dim>
void put_pair_blocks(auto i, auto j, auto&& B, auto&& entry) {
  for (int b = 0; b < dim; ++b)
    for (int a = 0; a < dim; ++a) {
      const auto x = B(a, b);
      entry(dim * i + a, dim * j + b, x);
      entry(dim * j + a, dim * i + b, x);
      entry(dim * i + a, dim * i + b, -x);
      entry(dim * j + a, dim * j + b, -x);
    }
}
/// A pair's tangents K = ∂f_i/∂r_j and C = ∂f_i/∂v_j, as an edge where the sink takes one, else as entries.
/// @tparam has_C  whether the force depends on velocities
template <int dim, bool has_C, class Scalar>
void put_pair(auto& sink, auto i, auto j, const Scalar* n, const PairTangent<Scalar>& K, const PairTangent<Scalar>& C) {
  if constexpr (requires { sink.edge(i, j, n, K, C); }) {
    sink.edge(i, j, n, K, C);
  } else {
    const auto block = [n](const PairTangent<Scalar>& of) {
      return [n, of](int a, int b) {
        const Scalar along = n[a] * n[b];
        return of.along * along + of.across * (Scalar(a == b) - along);
      };
    };
    put_pair_blocks<dim>(i, j, block(K), [&sink](auto row, auto column, Scalar x) { sink.position(row, column, x); });
    if constexpr (has_C)
      put_pair_blocks<dim>(i, j, block(C), [&sink](auto row, auto column, Scalar x) { sink.velocity(row, column, x); });
  }
}

}}  // namespace phistep::PHISTEP_ABI
