/// @file
/// Preconditioned Krylov methods as the last argument of a stepper: what a user names (preconditioned_system.hpp says how they work).
#pragma once

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include <concepts>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/machine/only.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/krylov/methods.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Eigen's, without a permutation: on grids numbered row by row it needs fewer iterations than with one.
using IncompleteCholesky = Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>>;

/// The last argument of a stepper, `newton<PreconditionedCg<P>>()`, or with a preconditioner that holds something,
/// `newton(PreconditionedCg<P>{mine})`, which is copied.
template <KrylovMethod which, class P>
struct PreconditionedKrylov {
  static constexpr KrylovMethod method = which;
  using Preconditioner = P;
  static constexpr bool is_copied = std::copy_constructible<P>;
  [[no_unique_address]] Only<is_copied, P> preconditioner{};
};
/// Conjugate gradients, for symmetric positive definite W.
template <class P = Eigen::DiagonalPreconditioner<double>>
using PreconditionedCg = PreconditionedKrylov<KrylovMethod::conjugate_gradients, P>;
/// BiCGSTAB, for any W: two products an iteration.
template <class P = Eigen::DiagonalPreconditioner<double>>
using PreconditionedBicgstab = PreconditionedKrylov<KrylovMethod::bicgstab, P>;
/// GMRES, for any W: restarted after 30 vectors.
template <class P = Eigen::DiagonalPreconditioner<double>>
using PreconditionedGmres = PreconditionedKrylov<KrylovMethod::gmres, P>;

/// Conjugate gradients while W is symmetric, BiCGSTAB elsewhere, both with incomplete factors that differ from W on the diagonal
/// alone; of a W whose pattern is unsymmetric BiCGSTAB with W's diagonal.
using PreconditionedBySymmetry = PreconditionedKrylov<KrylovMethod::by_symmetry, Eigen::DiagonalPreconditioner<double>>;

template <KrylovMethod method, class P>
inline constexpr bool is_preconditioned_krylov<PreconditionedKrylov<method, P>> = true;

}}  // namespace phistep::PHISTEP_ABI
