/// @file
/// What the automatic choice asks of a large sparse Jacobian: whether a factorization or Krylov iterations cost less, counted
/// from its pattern before anything is factorized.
#pragma once

#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/linear/krylov/methods.hpp"
#include "phistep/linear/krylov/preconditioned_system.hpp"
#include "phistep/linear/sparse/factor_cost.hpp"
#include "phistep/run/choice/suitable_scheme.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Part of <phistep/sparse.hpp>.
template <class Scalar>
struct FieldMatrix {
  using Solver = Newton<PreconditionedKrylov<KrylovMethod::by_symmetry, Eigen::DiagonalPreconditioner<Scalar>>>;

  /// Makes the Jacobian of a stepper by Krylov iterations at (t, y), and counts what its factors would cost, until that is more
  /// than the iterations do.
  /// @param problem  what else is known of it
  /// @return entries < 0 where the Jacobian isn't finite
  template <State S>
  [[nodiscard]] static FieldCounts count(auto& stepper, Scalar t, Scalar dt, const PlainState<S>& y,
                                         const SolveTolerance<PlainState<S>>& weights, AdvisedProblem problem) {
    constexpr Scalar epsilon = std::numeric_limits<Scalar>::epsilon();
    const Scalar tolerance = problem.has_jacobian ? 16 * epsilon : 64 * std::sqrt(epsilon);
    FieldCounts counts;
    auto& kernel = StepperInternals::kernel(stepper);
    auto psi = make_rate<S>(y);
    kernel.rhs().begin(t, dt, y);
    if (failed(kernel.resolvent().linearize(kernel.rhs(), t, dt, y, psi, false, weights))) return counts;
    auto& system = kernel.resolvent().matrix().system();
    static_cast<void>(system.settle(each_mass_entry<S>(kernel.rhs().masses(), y)));
    counts.is_symmetric = true;
    using Matrix = Eigen::SparseMatrix<Scalar>;
    Matrix A = system.pattern();
    const auto largest = [](const auto& x) { return x.matrix().template lpNorm<Eigen::Infinity>(); };
    for (int of_K = 0; of_K <= (Blocks<S>::drifts ? 1 : 0); ++of_K) {
      system.for_each_tangent([&](std::size_t p, Scalar k, Scalar c) { A.valuePtr()[p] = of_K == 1 ? k : c; });
      const Matrix T = A.transpose();
      counts.is_symmetric = counts.is_symmetric &&
                            std::equal(A.innerIndexPtr(), A.innerIndexPtr() + A.nonZeros(), T.innerIndexPtr()) &&
                            std::equal(A.outerIndexPtr(), A.outerIndexPtr() + A.cols(), T.outerIndexPtr()) &&
                            largest(A.coeffs() - T.coeffs()) <= tolerance * largest(A.coeffs());
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

}}  // namespace phistep::PHISTEP_ABI
