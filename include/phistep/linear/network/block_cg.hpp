/// @file
/// Conjugate gradients with the inverse diagonal blocks as preconditioner (Hestenes & Stiefel 1952; Golub & Van Loan,
/// Matrix Computations, sect. 11.5), for an EdgeOperator. Three sweeps an iteration: the direction and its node part,
/// the edges with p·Ap, and all that follows from α together.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "phistep/base/version.hpp"
#include "phistep/linear/network/edge_operator.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A⁻¹ in place of a small symmetric matrix A, by Gauss-Jordan without pivoting. False unless A is positive definite.
template <int dim, class Block>
[[nodiscard]] bool invert_definite(Block& A) {
  for (int k = 0; k < dim; ++k) {
    const auto pivot = A[k][k];
    if (!(pivot > 0) || !std::isfinite(pivot)) return false;
    const auto inverse = 1 / pivot;
    A[k][k] = 1;
    for (int j = 0; j < dim; ++j) A[j][k] *= inverse;
    for (int i = 0; i < dim; ++i) {
      if (i == k) continue;
      const auto factor = A[k][i];
      A[k][i] = 0;
      for (int j = 0; j < dim; ++j) A[j][i] -= factor * A[j][k];
    }
  }
  return true;
}

template <class Scalar, int dim>
class BlockCg {
 public:
  using Operator = EdgeOperator<Scalar, dim>;
  using Node = typename Operator::Node;
  using Block = typename Operator::Block;
  enum class End { converged, indefinite, gave_up };

  void resize(std::size_t nodes) {
    for (auto* all : {&x_, &r_, &z_, &p_, &y_}) all->assign(nodes, Node::Zero());
    inverse_.resize(nodes);
  }
  /// Right-hand side on entry to solve().
  [[nodiscard]] std::vector<Node>& residual() { return r_; }
  /// The solution after solve().
  [[nodiscard]] const std::vector<Node>& solution() const { return x_; }
  [[nodiscard]] int iterations() const { return iterations_; }

  /// Makes the preconditioner. False where a diagonal block, hence A, is not positive definite.
  /// @param largest  a number a node: the largest of A's diagonal there
  [[nodiscard]] bool precondition(const Operator& A, std::vector<Scalar>& largest) {
    bool definite = true;
    A.diagonal_blocks(inverse_, largest);
    for (std::size_t i = 0; i < inverse_.size(); ++i) {
      Block& block = inverse_[i];
      largest[i] = Scalar{0};
      Scalar copy[dim][dim];
      for (int b = 0; b < dim; ++b)
        for (int a = 0; a < dim; ++a) copy[b][a] = block[static_cast<std::size_t>(b)][a];
      for (int a = 0; a < dim; ++a) largest[i] = std::max(largest[i], std::abs(copy[a][a]));
      definite = invert_definite<dim>(copy) && definite;
      for (int b = 0; b < dim; ++b) {
        block[static_cast<std::size_t>(b)].setZero();
        for (int a = 0; a < dim; ++a) block[static_cast<std::size_t>(b)][a] = copy[b][a];
      }
    }
    return definite;
  }

  /// A x = residual(), until ‖residual‖ ≤ rtol ‖right-hand side‖, both in the Euclidean norm and in that of the inverse
  /// diagonal blocks: a heavy node's large force must not hide what is left to do on light ones.
  [[nodiscard]] End solve(const Operator& A, Scalar rtol, int most_iterations) {
    const std::size_t n = A.nodes();
    Node *const x = x_.data(), *const r = r_.data(), *const z = z_.data(), *const p = p_.data(), *const y = y_.data();
    const Block* const inverse = inverse_.data();
    iterations_ = 0;
    Node sum_rr = Node::Zero(), sum_rz = Node::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      x[i].setZero();
      z[i] = Operator::product(inverse[i], r[i]);
      sum_rr += r[i] * r[i];
      sum_rz += r[i] * z[i];
    }
    Scalar rz = sum_rz.sum(), beta{0};
    const Scalar target_rr = rtol * rtol * sum_rr.sum(), target_rz = rtol * rtol * rz;
    if (sum_rr.sum() == Scalar{0}) return End::converged;
    while (iterations_ < most_iterations) {
      ++iterations_;
      for (std::size_t i = 0; i < n; ++i) {
        p[i] = iterations_ == 1 ? z[i] : Node(z[i] + beta * p[i]);
        y[i] = A.node(i, p[i]);
      }
      const Scalar curvature = A.add_edges(p, y);
      if (!(curvature > Scalar{0})) return End::indefinite;
      const Scalar alpha = rz / curvature;
      sum_rr.setZero();
      sum_rz.setZero();
      for (std::size_t i = 0; i < n; ++i) {
        x[i] += alpha * p[i];
        const Node rest = r[i] - alpha * y[i];
        const Node better = Operator::product(inverse[i], rest);
        r[i] = rest;
        z[i] = better;
        sum_rr += rest * rest;
        sum_rz += rest * better;
      }
      const Scalar next = sum_rz.sum();
      if (sum_rr.sum() <= target_rr && next <= target_rz) return End::converged;
      beta = next / rz;
      rz = next;
    }
    return End::gave_up;
  }

 private:
  std::vector<Node> x_, r_, z_, p_, y_;
  std::vector<Block> inverse_;
  int iterations_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
