/// @file
/// Which dense solver is the faster one for a size, and for how many solves its factors will serve.
///
/// Factorisation and one solve in ns, the next solve waiting for this one's answer (double, Zen 4, g++ 12; bench/small_dense):
///
///         -O2 (SSE2)                       -O3 -march=native
///     n   LU           inverse     even    LU          inverse     even after
///     2     3 +   8      9 +  5     1.6      3 +   9     5 +  5     0.4 solves
///     3    12 +  16     26 +  7     1.6     13 +  14    15 +  7     0.3
///     4    21 +  27     32 +  6     0.6     15 +  19    22 +  6     0.5
///     5    44 +  31     53 +  7     0.4     42 +  22    47 +  7     0.4
///     8    82 +  44    134 + 11     1.6     65 +  42    77 + 11     0.4
///    12   173 +  63    338 + 18     3.7    126 +  59   175 + 14     1.1
///    15   299 +  87    627 + 25     5.3    280 +  73   529 + 26     5.3
///    20   674 + 150   1486 + 40     7.4    446 + 111   729 + 25     3.3
///
/// So the inverse serves one or two solves for 4 ≤ n ≤ 8, and many for every fixed n.
#pragma once

#include <type_traits>

#include "phistep/core/version.hpp"
#include "phistep/linear/dense_inverse.hpp"
#include "phistep/linear/dense_lu.hpp"

namespace phistep::inline PHISTEP_ABI {

/// How a factorisation of fixed size is best kept. Dynamic and large sizes have LU alone.
template <int size, bool many_solves>
inline constexpr bool prefers_inverse = size > 0 && size <= small_dense_limit &&
                                        (many_solves || (4 <= size && size <= 8));

template <class Scalar, int size, bool many_solves, bool inverse = prefers_inverse<size, many_solves>>
struct SmallDenseSolverFor {
  using type = DenseLu<Scalar, size>;
};
template <class Scalar, int size, bool many_solves>
struct SmallDenseSolverFor<Scalar, size, many_solves, true> {
  using type = DenseInverse<Scalar, size>;
};

/// @tparam many_solves  one factorisation a run (affine forces), as against one or two solves each (Newton)
template <class Scalar, int size, bool many_solves>
using SmallDenseSolver = typename SmallDenseSolverFor<Scalar, size, many_solves>::type;

}  // namespace phistep::inline PHISTEP_ABI
