/// @file
/// What the automatic choice asks of a large sparse Jacobian: whether a factorization or Krylov iterations cost less, counted
/// from its pattern before anything is factorized.
#pragma once

#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "phistep/choice/scheme_set.hpp"
#include "phistep/choice/suitable_scheme.hpp"
#include "phistep/core/implicit_solver.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/version.hpp"
#include "phistep/equation/bound_masses.hpp"
#include "phistep/equation/gamma.hpp"
#include "phistep/equation/right_hand_side.hpp"
#include "phistep/krylov/modified_incomplete_cholesky.hpp"
#include "phistep/krylov/preconditioned_system.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/matrix/sparse/factor_cost.hpp"
#include "phistep/solve/linearisation.hpp"
#include "phistep/state/blocks.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Whether a_ij = a_ji within tolerance · (the largest entry), and both have a slot. Row by row: the transposes of the columns'
/// entries come in the order in which they are stored.
template <class Scalar>
[[nodiscard]] bool is_symmetric(const Eigen::SparseMatrix<Scalar>& A, Scalar tolerance) {
  const auto *const outer = A.outerIndexPtr(), *const inner = A.innerIndexPtr();
  std::vector<typename Eigen::SparseMatrix<Scalar>::StorageIndex> next(outer, outer + A.cols());
  Scalar largest{0}, apart{0};
  for (Eigen::Index j = 0; j < A.cols(); ++j)
    for (auto p = outer[j]; p < outer[j + 1]; ++p) {
      const auto q = next[static_cast<std::size_t>(inner[p])]++;
      if (q >= outer[inner[p] + 1] || inner[q] != j) return false;
      largest = std::max(largest, std::abs(A.valuePtr()[p]));
      apart = std::max(apart, std::abs(A.valuePtr()[p] - A.valuePtr()[q]));
    }
  return apart <= tolerance * largest;
}

/// Part of <phistep/sparse.hpp>.
template <class Scalar>
struct FieldMatrix {
  using Solver = Newton<PreconditionedKrylov<KrylovMethod::by_symmetry, Eigen::DiagonalPreconditioner<Scalar>>>;

  /// Looks at K and C at (t, y): a Jacobian, and a force call for differences.
  /// The fill is counted until it says that Krylov iterations cost less.
  /// @param problem  what else is known of it
  /// @param spent    adds what it has cost
  /// @return entries < 0 where K or C are not finite
  template <State S, class F, class MassSpec>
  [[nodiscard]] static FieldCounts look(const F& force, const MassSpec& mass, Scalar t, const PlainState<S>& y,
                                        AdvisedProblem problem, Statistics& spent) {
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
    static_cast<void>(system.settle(each_mass_entry<S>(rhs.masses(), y)));
    Eigen::SparseMatrix<Scalar> A = system.pattern();
    const Scalar tolerance = (Matrix::analytic ? 16 : 64) * (Matrix::analytic ? epsilon : std::sqrt(epsilon));
    counts.is_symmetric = true;
    for (int of_K = 0; of_K <= (Rhs::drifts ? 1 : 0); ++of_K) {
      system.for_each_tangent([&](std::size_t p, Scalar k, Scalar c) { A.valuePtr()[p] = of_K == 1 ? k : c; });
      counts.is_symmetric = counts.is_symmetric && is_symmetric(A, tolerance);
    }
    counts.row = static_cast<double>(A.nonZeros()) / static_cast<double>(std::max<Eigen::Index>(1, A.cols()));
    const auto set = [&counts](const FactorCost& cost) {
      counts.entries = cost.entries_an_unknown();
      counts.products = cost.products_an_unknown();
    };
    set(factor_cost(A, [&](const FactorCost& part) {
      set(part);
      problem.field = counts;
      return is_for_krylov(problem);
    }));
    return counts;
  }
};

}  // namespace phistep::inline PHISTEP_ABI
