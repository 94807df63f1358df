/// @file
/// What the automatic choice asks of a large sparse Jacobian: whether a factorization or conjugate gradients cost less, counted
/// from its pattern before anything is factorized.
#pragma once

#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/core/implicit_solver.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/version.hpp"
#include "phistep/equation/gamma.hpp"
#include "phistep/equation/right_hand_side.hpp"
#include "phistep/krylov/modified_incomplete_cholesky.hpp"
#include "phistep/krylov/preconditioned_system.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/matrix/factor_cost.hpp"
#include "phistep/schemes/choice.hpp"
#include "phistep/solve/linearisation.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/step/scheme_set.hpp"

namespace phistep::inline PHISTEP_ABI {

/// A comes as its pattern and its values. Whether |a_ij − a_ji| ≤ tolerance · (the largest entry), where both have a slot.
template <class Scalar>
[[nodiscard]] bool is_symmetric(const Eigen::SparseMatrix<Scalar>& A, Scalar tolerance) {
  const Eigen::SparseMatrix<Scalar> transposed = A.transpose();
  const auto n = static_cast<std::size_t>(A.nonZeros());
  if (!std::equal(A.innerIndexPtr(), A.innerIndexPtr() + n, transposed.innerIndexPtr())) return false;
  Scalar largest{0}, apart{0};
  for (std::size_t k = 0; k < n; ++k) {
    largest = std::max(largest, std::abs(A.valuePtr()[k]));
    apart = std::max(apart, std::abs(A.valuePtr()[k] - transposed.valuePtr()[k]));
  }
  return apart <= tolerance * largest;
}

/// Part of <phistep/sparse.hpp>.
template <class Scalar>
struct FieldMatrix {
  using Solver = Newton<PreconditionedCg<ModifiedIncompleteCholesky<Scalar>>>;

  /// Looks at K and C at (t, y): a Jacobian, and a force call for differences.
  /// @param spent  adds what it has cost. @return entries < 0 where they are not finite
  template <State S, class F, class MassSpec>
  [[nodiscard]] static FieldCounts look(const F& force, const MassSpec& mass, Scalar t, const PlainState<S>& y,
                                        Statistics& spent) {
    using Masses = decltype(bind_masses<S>(mass, y));
    using Rhs = RightHandSide<S, F, Masses>;
    using Matrix = Linearisation<S, Rhs, void, true, true, true>;
    constexpr Scalar epsilon = std::numeric_limits<Scalar>::epsilon();
    Rhs rhs{F(force), bind_masses<S>(mass, y)};
    Matrix matrix;
    matrix.resize(y, rhs);
    auto psi = make_rate<S>(y);
    rhs.begin(t, Scalar{0}, y);
    if constexpr (!Matrix::analytic) rhs.evaluate_into(t, y, psi);
    const Outcome outcome = matrix.linearise(rhs, Gamma<Scalar>{1, 1}, t, y, psi, {}, {});
    spent = spent + rhs.statistics();
    FieldCounts counts;
    if (failed(outcome)) return counts;
    auto& system = matrix.system();
    static_cast<void>(system.settle(each_mass_entry<S>(rhs, y)));
    Eigen::SparseMatrix<Scalar> C = system.pattern(), K = C;
    system.for_each_tangent([&](std::size_t p, Scalar k, Scalar c) { K.valuePtr()[p] = k, C.valuePtr()[p] = c; });
    const Scalar tolerance = (Matrix::analytic ? 16 : 64) * (Matrix::analytic ? epsilon : std::sqrt(epsilon));
    counts.is_symmetric = is_symmetric(C, tolerance) && is_symmetric(K, tolerance);
    const FactorCost cost = factor_cost(C);
    const auto n = static_cast<double>(std::max<Eigen::Index>(1, C.cols()));
    counts.entries = cost.entries_an_unknown();
    counts.products = cost.products_an_unknown();
    counts.row = static_cast<double>(C.nonZeros()) / n;
    return counts;
  }
};

}  // namespace phistep::inline PHISTEP_ABI
