/// @file
/// The matrix of a network of pairs, never assembled:
///
///     y_i = N_i x_i + Σ_e B_e (x_i − x_j),     B_e = a I ± w wᵀ
///
/// N_i is a node's own block (its mass and what acts on it alone), B_e the block of the edge e = (i, j). Four numbers an
/// edge in three dimensions, where an assembled matrix has 2 × 9 and indices beside them: conjugate gradients live on
/// bandwidth. Measured (2 compilers, SSE2 and AVX-512, 10,000 and 40,000 particles): vectors padded to four numbers a
/// node, the edges of a node together, y_i in a register: 1.7 times as fast as edges in any order on packed vectors.
/// Numbers of half the size would spare memory, but their conversion cost more than it saved.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
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

  std::vector<Node> diagonal;           ///< of each N_i
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

}}  // namespace phistep::PHISTEP_ABI
