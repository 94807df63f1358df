/// @file
/// The matrix of a network of pairs, never assembled, and conjugate gradients for it:
///
///     y_i = N_i x_i + Σ_e B_e (x_i − x_j),     B_e = a I ± w wᵀ
///
/// N_i is a node's own block (its mass and what acts on it alone), B_e the block of the edge e = (i, j). Four numbers an
/// edge in three dimensions, where an assembled matrix has 2 × 9 and indices beside them: conjugate gradients live on
/// bandwidth. Vectors padded to four numbers a node, the edges of a node together, y_i in a register: 1.7 times as fast as
/// edges in any order on packed vectors.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// One node's vector, padded with zeros, so that one load or store moves it.
template <class Scalar>
using Lanes = Eigen::Array<Scalar, 4, 1>;

template <class Scalar, int dim>
class EdgeOperator {
  static_assert(dim >= 1 && dim <= 3);

 public:
  using Node = Lanes<Scalar>;
  using Block = std::array<Node, dim>;  // columns

  std::vector<Node> diagonal;           ///< diagonals of the nodes' own blocks N_i
  std::vector<Block> coupling;          ///< the whole N_i instead; empty where all are diagonal
  std::vector<std::int32_t> start;      ///< the edges of node i to later nodes: start[i] … start[i+1] − 1
  std::vector<std::int32_t> neighbour;  ///< j > i of each edge
  std::vector<Node> edges;              ///< w, and a in the last lane
  std::vector<Scalar> signs;            ///< ±1 of each w wᵀ
  bool has_signs = false;               ///< whether any is −1

  [[nodiscard]] std::size_t nodes() const { return diagonal.size(); }

  /// Makes room for the edges between the nodes sorted[e].first, (i, j) with i < j, in this order.
  void connect(const auto& sorted) {
    start.assign(nodes() + 1, 0);
    neighbour.resize(sorted.size());
    edges.resize(sorted.size());
    signs.assign(sorted.size(), Scalar{1});
    for (std::size_t e = 0; e < sorted.size(); ++e) {
      ++start[static_cast<std::size_t>(sorted[e].first.first) + 1];
      neighbour[e] = sorted[e].first.second;
    }
    for (std::size_t i = 0; i < nodes(); ++i) start[i + 1] += start[i];
  }

  /// N_i x
  [[nodiscard, gnu::always_inline]] inline Node node(std::size_t i, const Node& x) const {
    if (coupling.empty()) return diagonal[i] * x;
    return product(coupling[i], x);
  }
  [[nodiscard, gnu::always_inline]] static inline Node product(const Block& block, const Node& x) {
    Node y = block[0] * x[0];
    for (std::size_t b = 1; b < dim; ++b) y += block[b] * x[static_cast<Eigen::Index>(b)];
    return y;
  }

  /// y += Σ B_e (x_i − x_j); y holds N x on entry. Returns x·y.
  [[nodiscard]] Scalar add_edges(const Node* x, Node* y) const {
    return has_signs ? add_edges<true>(x, y) : add_edges<false>(x, y);
  }

  /// The diagonal blocks N_i + Σ B_e into `sum`; the last row is padding of any value. `scratch`: a number a node.
  void diagonal_blocks(std::vector<Block>& sum, std::vector<Scalar>& scratch) const {
    for (std::size_t i = 0; i < nodes(); ++i)
      for (std::size_t b = 0; b < dim; ++b) {
        if (coupling.empty()) sum[i][b].setZero();
        else sum[i][b] = coupling[i][b];
      }
    std::fill(scratch.begin(), scratch.end(), Scalar{0});
    std::size_t e = 0;
    for (std::size_t i = 0; i < nodes(); ++i) {
      Block own = sum[i];
      Scalar across = scratch[i];
      for (const auto last = static_cast<std::size_t>(start[i + 1]); e < last; ++e) {
        const auto j = static_cast<std::size_t>(neighbour[e]);
        const Node w = edges[e];
        const Scalar a = edges[e][3], s = has_signs ? signs[e] : Scalar{1};
        across += a;
        scratch[j] += a;
        for (std::size_t b = 0; b < dim; ++b) {
          const Node column = w * (s * edges[e][static_cast<Eigen::Index>(b)]);
          own[b] += column;
          sum[j][b] += column;
        }
      }
      for (std::size_t b = 0; b < dim; ++b) {
        const auto at = static_cast<Eigen::Index>(b);
        sum[i][b] = own[b];
        sum[i][b][at] += across;
        if (coupling.empty()) sum[i][b][at] += diagonal[i][at];
      }
    }
  }

 private:
  template <bool with_signs>
  [[nodiscard]] Scalar add_edges(const Node* x, Node* y) const {
    const std::int32_t *const first = start.data(), *const to = neighbour.data();
    const Node* const edge = edges.data();
    Node product = Node::Zero();
    std::int32_t e = 0;
    for (std::size_t i = 0; i < nodes(); ++i) {
      const Node here = x[i];
      Node sum = y[i];
      for (const std::int32_t last = first[i + 1]; e < last; ++e) {
        const std::int32_t j = to[e];
        const Node w = edge[e];
        const Node d = here - x[j];
        Scalar h = (w * d).sum();  // the last lane of d is 0
        if constexpr (with_signs) h *= signs[static_cast<std::size_t>(e)];
        const Node q = edge[e][3] * d + h * w;
        sum += q;
        y[j] -= q;
      }
      product += here * sum;
      y[i] = sum;
      y[i][3] = Scalar{0};
    }
    return product.sum();
  }
};

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

/// Conjugate gradients with the inverse diagonal blocks as preconditioner (Hestenes & Stiefel 1952; Golub & Van Loan, Matrix
/// Computations, sect. 11.5). Three sweeps an iteration: the direction and its node part, the edges with p·Ap, and all that
/// follows from α together.
template <class Scalar, int dim>
class BlockCg {
 public:
  using Operator = EdgeOperator<Scalar, dim>;
  using Node = typename Operator::Node;
  using Block = typename Operator::Block;
  enum class End { converged, indefinite, gave_up };

  std::vector<Node> residual;  ///< the right-hand side on entry to solve()
  std::vector<Node> solution;  ///< after it
  int iterations = 0;          ///< of the last solve()

  void resize(std::size_t nodes) {
    for (auto* all : {&solution, &residual, &z_, &p_, &y_}) all->assign(nodes, Node::Zero());
    inverse_.resize(nodes);
  }

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

  /// A x = residual, until ‖residual‖ ≤ rtol ‖right-hand side‖, both in the Euclidean norm and in that of the inverse
  /// diagonal blocks: a heavy node's large force must not hide what is left to do on light ones.
  [[nodiscard]] End solve(const Operator& A, Scalar rtol, int most) {
    const std::size_t n = A.nodes();
    Node *const x = solution.data(), *const r = residual.data(), *const z = z_.data(), *const p = p_.data(),
                *const y = y_.data();
    const Block* const inverse = inverse_.data();
    iterations = 0;
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
    while (iterations < most) {
      ++iterations;
      for (std::size_t i = 0; i < n; ++i) {
        p[i] = iterations == 1 ? z[i] : Node(z[i] + beta * p[i]);
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
  std::vector<Node> z_, p_, y_;
  std::vector<Block> inverse_;
};

}}  // namespace phistep::PHISTEP_ABI
