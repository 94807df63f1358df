/// @file
/// Guaranteed upper bounds of eigenvalues from a matrix's entries: Gershgorin's discs, sharpened by weights.
///
/// For any weights x > 0,
///
///     ρ(A) ≤ max_i Σ_j |A_ij| x_j / x_i                                   Collatz & Wielandt                        (1)
///     λ_max(A) ≤ max_i λ_max(A_ii + Σ_{j≠i} (x_j/x_i) |A_ij|)             A symmetric, in blocks, |B| = (B Bᵀ)^½    (2)
///
/// (2) because with B = U Σ Vᵀ, 2 x_iᵀ B x_j ≤ c x_iᵀ U Σ Uᵀ x_i + c⁻¹ x_jᵀ V Σ Vᵀ x_j for every c > 0. The sum over
/// neighbours stays a matrix, so that springs of different directions don't add up as if they were parallel: on the triangular
/// lattice (2) is exact, 6 k/m, where entries alone give 7.7. Weights move towards the blocks that
/// have the largest bound; every iterate is a bound, the smallest is kept. (Power iteration comes from below: unsafe.)
///
/// Horn & Johnson, Matrix Analysis, sect. 6.1 and 8.1.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// An upper bound and the row that it comes from.
struct EigenvalueBound {
  double value = 0;
  Eigen::Index row = -1;
};

/// Weights x, moved from bound to bound; the smallest bound is kept.
/// @param bounds  bounds(x, out): out_i(x), so that max_i out_i bounds the eigenvalue for every x > 0
template <class Bounds>
[[nodiscard]] EigenvalueBound improve_weights(Eigen::VectorXd x, double shift, Bounds&& bounds) {
  EigenvalueBound best{std::numeric_limits<double>::infinity(), -1};
  Eigen::VectorXd now(x.size());
  double seen = best.value;
  for (int k = 0; k < 60 && x.size() > 0; ++k) {
    bounds(x, now);
    Eigen::Index where = 0;
    const double top = now.maxCoeff(&where);
    if (top < best.value) best = {top, where};
    if (!(top + shift > 0)) break;
    if (k % 10 == 9) {
      if (!(best.value < 0.999 * seen)) break;
      seen = best.value;
    }
    x.array() *= (now.array() + shift) / (top + shift);
  }
  return x.size() > 0 ? best : EigenvalueBound{};
}

/// (B Bᵀ)^½
template <int d>
[[nodiscard]] Eigen::Matrix<double, d, d> modulus(const Eigen::Matrix<double, d, d>& B) {
  const bool symmetric = (B - B.transpose()).cwiseAbs().maxCoeff() <= 1e-14 * B.cwiseAbs().maxCoeff();
  const Eigen::Matrix<double, d, d> S = symmetric ? B : Eigen::Matrix<double, d, d>(B * B.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, d, d>> solver(S);
  const auto values = solver.eigenvalues().cwiseAbs().eval();
  const auto sizes = symmetric ? values : values.cwiseSqrt().eval();
  return solver.eigenvectors() * sizes.asDiagonal() * solver.eigenvectors().transpose();
}

/// (2) for A u = λ M u with M = diag(m), m alike within a block.
template <int d>
[[nodiscard]] EigenvalueBound largest_eigenvalue_bound_by_blocks(const SparseRows& A, const Eigen::VectorXd& m) {
  using Block = Eigen::Matrix<double, d, d>;
  struct Neighbour {
    Eigen::Index row, column;
    Block block;
  };
  const Eigen::Index n = A.rows() / d;
  std::vector<Block> own(static_cast<std::size_t>(n), Block::Zero());
  std::vector<Neighbour> neighbours;                                // row after row
  std::vector<std::size_t> places(static_cast<std::size_t>(n), 0);  // 1 + that of each column's latest block
  Eigen::VectorXd mass(n);
  double shift = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    Block& mine = own[static_cast<std::size_t>(i)];
    const std::size_t start = neighbours.size();
    for (Eigen::Index a = 0; a < d; ++a)
      for (SparseRows::InnerIterator entry(A, i * d + a); entry; ++entry) {
        const Eigen::Index j = entry.col() / d;
        std::size_t& place = places[static_cast<std::size_t>(j)];
        if (j != i && place <= start) {
          neighbours.push_back({i, j, Block::Zero()});
          place = neighbours.size();
        }
        (j == i ? mine : neighbours[place - 1].block)(a, entry.col() % d) += entry.value();
      }
    for (std::size_t p = start; p < neighbours.size(); ++p) neighbours[p].block = modulus<d>(neighbours[p].block);
    mine = ((mine + mine.transpose()) / 2).eval();
    mass[i] = m[i * d];
    shift = std::max(shift, mine.cwiseAbs().rowwise().sum().maxCoeff() / mass[i]);
  }
  const auto bounds = [&](const Eigen::VectorXd& x, Eigen::VectorXd& out) {
    auto next = neighbours.begin();
    for (Eigen::Index i = 0; i < n; ++i) {
      Block sum = own[static_cast<std::size_t>(i)];
      for (; next != neighbours.end() && next->row == i; ++next) sum += (x[next->column] / x[i]) * next->block;
      const Eigen::SelfAdjointEigenSolver<Block> solver(sum, Eigen::EigenvaluesOnly);
      out[i] = solver.eigenvalues().maxCoeff() / mass[i];
    }
  };
  // Weights start from 1, which shows that a network is definite, and from m^−½: heavy particles move less in stiff modes.
  EigenvalueBound bound = improve_weights(Eigen::VectorXd::Ones(n), 2 * shift, bounds);
  if (n > 0 && mass.minCoeff() < mass.maxCoeff()) {
    const EigenvalueBound other =
        improve_weights((mass.maxCoeff() * mass.cwiseInverse()).cwiseSqrt(), 2 * shift, bounds);
    if (other.value < bound.value) bound = other;
  }
  bound.row *= d;
  return bound;
}

/// An upper bound of the largest λ of A u = λ diag(m) u. @param A symmetric  @param block rows of a particle, where known
template <class = void>
[[nodiscard]] EigenvalueBound largest_eigenvalue_bound(const SparseRows& A, const Eigen::VectorXd& m, int block) {
  EigenvalueBound bound = largest_eigenvalue_bound_by_blocks<1>(A, m);
  bool alike = block > 1 && A.rows() % block == 0;
  for (Eigen::Index i = 0; alike && i < m.size(); ++i) alike = m[i] == m[i / block * block];
  if (!alike || block > 3) return bound;
  const EigenvalueBound other =
      block == 2 ? largest_eigenvalue_bound_by_blocks<2>(A, m) : largest_eigenvalue_bound_by_blocks<3>(A, m);
  return other.value < bound.value ? other : bound;
}

/// (1), by rows or by columns: an upper bound of the spectral radius of any square matrix.
template <class = void>
[[nodiscard]] EigenvalueBound spectral_radius_bound(const SparseRows& A) {
  const auto by_rows = [](const SparseRows& B) {
    return improve_weights(Eigen::VectorXd::Ones(B.rows()), 0, [&B](const Eigen::VectorXd& x, Eigen::VectorXd& out) {
      for (Eigen::Index i = 0; i < B.rows(); ++i) {
        double sum = 0;
        for (SparseRows::InnerIterator entry(B, i); entry; ++entry) sum += std::abs(entry.value()) * x[entry.col()];
        out[i] = sum / x[i];
      }
      out = out.cwiseMax(out.maxCoeff() * 1e-3);  // the weights of zero rows would vanish
    });
  };
  const EigenvalueBound rows = by_rows(A), columns = by_rows(SparseRows(A.transpose()));
  return columns.value < rows.value ? columns : rows;
}

}}  // namespace phistep::PHISTEP_ABI
