/// @file
/// Which linear system serves W = M − γ_f C − γ_f γ_d K: of `systems`, the first row that takes what is known of W at compile
/// time. A new system is a header of its own and a row here; the table of docs/reference/solvers.md is printed from these.
#pragma once

#include <Eigen/Core>

#include <array>

#include "phistep/base/facts/structure.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What is known at compile time of W: enough to choose how to solve with it.
struct MatrixFacts {
  Structure structure = Structure::dense;
  int n = Eigen::Dynamic;       ///< unknowns
  bool has_K = false;           ///< ∂Ψ/∂r is there
  bool has_C = false;           ///< ∂Ψ/∂v (or ∂Ψ/∂y) is there
  bool symmetric = false;       ///< K, C and M are
  bool constant = false;        ///< the force is affine: K and C never change, one factorization serves many solves
  bool iterated = false;        ///< Newton's iteration corrects what the matrix's error leaves
  bool shifted = false;         ///< with K and C several complex matrices are factorized (lane_system.hpp)
  int block = 0;                ///< rows of a particle's block, 0 where there is none
  bool differenced = false;     ///< K and C are made by differences: symmetric, if at all, only to their accuracy
  bool static_pattern = false;  ///< the entries of W are known one by one, and spare half of an elimination
  bool own_solver = false;      ///< the user named a class with Eigen's sparse solver interface
  bool matrix_free = false;     ///< the user named a solver that wants products in place of a matrix
  bool preconditioned = false;  ///< the user named a preconditioned Krylov method
};

/// The systems.
enum class SystemKind {
  matrix_free,
  preconditioned,
  own,
  diagonal,
  particles,
  static_pattern,
  edges,
  dense,
  banded,
  symmetric_sparse,
  sparse_either,
  sparse
};

/// One line of the table.
struct SystemRow {
  SystemKind kind;
  const char* name;    ///< as solver_name() says it
  const char* serves;  ///< which forces
  bool (*takes)(const MatrixFacts&);
};

/// Few unknowns, known at compile time: there, LU beats any iteration.
inline constexpr int small_network = 24;

inline constexpr auto systems = std::to_array<SystemRow>({
    {SystemKind::matrix_free, "Krylov iterations on products", "any, with `newton<MatrixFree<…>>()`",
     [](const MatrixFacts& W) { return W.matrix_free; }},
    {SystemKind::preconditioned, "preconditioned Krylov iterations",
     "sparse ones, with `newton<PreconditionedGmres<…>>()`", [](const MatrixFacts& W) { return W.preconditioned; }},
    {SystemKind::own, "a solver of the user's own", "any, with `newton<Solver>()`",
     [](const MatrixFacts& W) { return W.own_solver; }},
    {SystemKind::diagonal, "component by component", "each component depends on itself only",
     [](const MatrixFacts& W) { return W.structure <= Structure::diagonal; }},
    {SystemKind::particles, "LU of each particle's block", "`local`: each of several particles depends on itself only",
     [](const MatrixFacts& W) { return W.structure == Structure::local && W.block > 0 && W.block != W.n; }},
    {SystemKind::static_pattern, "LU by a pattern known at compile time",
     "9 to 32 unknowns of a first-order state whose `jacobian_pattern` spares half of an elimination",
     [](const MatrixFacts& W) { return W.structure == Structure::dense && W.static_pattern; }},
    {SystemKind::edges, "block-Jacobi conjugate gradients on the edge operator",
     "symmetric networks of springs and pairs, more than 24 unknowns",
     [](const MatrixFacts& W) {
       return !W.shifted && W.structure == Structure::network && W.symmetric && 1 <= W.block && W.block <= 3 &&
              (W.n == Eigen::Dynamic || W.n > small_network);
     }},
    {SystemKind::dense, "dense LU",
     "any other force of unknown structure; one particle; networks of at most 24 unknowns",
     [](const MatrixFacts& W) {
       return W.structure == Structure::dense || W.structure == Structure::local ||
              (W.structure == Structure::network && W.n != Eigen::Dynamic && W.n <= small_network);
     }},
    {SystemKind::banded, "banded LU", "`banded`: nothing far from the diagonal",
     [](const MatrixFacts& W) { return W.structure == Structure::banded; }},
    {SystemKind::symmetric_sparse, "sparse LDLT", "`symmetric` sparse ones; LU where it turns out indefinite",
     [](const MatrixFacts& W) { return W.structure == Structure::sparse && W.symmetric; }},
    {SystemKind::sparse_either, "sparse LDLT or LU",
     "other sparse ones: LDLT while W is found symmetric and positive definite, LU from then on",
     [](const MatrixFacts& W) { return !W.shifted && (W.iterated || !W.differenced || W.constant); }},
    {SystemKind::sparse, "sparse LU", "all others: patterns in linear stages, which aren't iterated, by differences",
     [](const MatrixFacts&) { return true; }},
});

[[nodiscard]] constexpr const SystemRow& system_row(const MatrixFacts& W) {
  for (const SystemRow& row : systems)
    if (row.takes(W)) return row;
  return systems.back();
}

/// The system behind a row: each header of a system says so of its own kind. `Solver` is what the user named, or void;
/// `Force` names the pattern where it is known.
template <SystemKind kind, MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor {
  static_assert(kind != SystemKind::own,
                "phistep: a linear solver of one's own needs a sparse Jacobian, and <phistep/sparse.hpp>");
  static_assert(kind == SystemKind::own, "phistep: this force has a sparse Jacobian: #include <phistep/sparse.hpp>");
  using type = int;  // no second error
};

}}  // namespace phistep::PHISTEP_ABI
