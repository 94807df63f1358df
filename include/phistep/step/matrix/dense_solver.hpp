/// @file
/// Which dense solver is the faster one for a size, and for how many solves its factors will serve.
///
/// Factorization and one solve in ns, the next solve waiting for this one's answer (double, Zen 4, g++ 12; bench/small_dense):
///
///         -O2 (SSE2)                           -O3 -march=native
///     n   LU           inverse     even after  LU           inverse     even after
///     2     5 +   8     10 +  5   1.7 solves      3 +   9     16 +  5    3.1 solves
///     3    12 +  16     27 +  7   1.7 solves     10 +  14     15 +  7    0.7 solves
///     4    21 +  22     32 +  6   0.7 solves     15 +  19     22 +  6    0.5 solves
///     5    45 +  29     53 + 10   0.4 solves     42 +  23     47 +  7    0.3 solves
///     8    90 +  42    140 + 11   1.6 solves     63 +  34     77 + 10    0.6 solves
///    12   171 +  60    334 + 18   3.9 solves    122 +  53    163 + 13    1.0 solves
///    15   303 +  83    633 + 26   5.8 solves    265 +  64    455 + 31    5.7 solves
///    20   676 + 155   1708 + 40   9.0 solves    409 + 101    664 + 33    3.7 solves
///
/// So the inverse serves one or two solves for 4 ≤ n ≤ 8, the six or eight of a Rosenbrock step for n ≤ 16, and many for
/// every fixed n. (Up to 3 rows, LU is now 5 + 6 and 11 + 9 in the second table.)
#pragma once

#include "phistep/base/version.hpp"
#include "phistep/step/matrix/dense_inverse.hpp"
#include "phistep/step/matrix/dense_lu.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// How a factorization of fixed size is best kept. Dynamic and large sizes have LU alone.
enum class Solves { few, several, many };
template <int size, Solves solves>
inline constexpr bool prefers_inverse = size > 0 && size <= small_dense_limit &&
                                        (solves == Solves::many || (4 <= size && size <= 8) ||
                                         (solves == Solves::several && 2 <= size && size <= 16));

template <class Scalar, int size, Solves solves, bool inverse = prefers_inverse<size, solves>>
struct SmallDenseSolverFor {
  using type = DenseLu<Scalar, size>;
};
template <class Scalar, int size, Solves solves>
struct SmallDenseSolverFor<Scalar, size, solves, true> {
  using type = DenseInverse<Scalar, size>;
};

/// @tparam solves  many: one factorization a run (affine forces); several: one a step of several stages; few: Newton's
template <class Scalar, int size, Solves solves>
using SmallDenseSolver = typename SmallDenseSolverFor<Scalar, size, solves>::type;

}}  // namespace phistep::PHISTEP_ABI
