/// @file
/// W between its own triangular factors, P⁻¹W at the price of the two triangular solves alone (S. C. Eisenstat, SIAM J. Sci. Stat.
/// Comput. 2 (1981) 1; Y. Saad, Iterative Methods for Sparse Linear Systems, 2nd ed., sect. 9.2.2). Of W = L + D_W + U,
///
///     P = (D + L) D⁻¹ (D + U),     d_i = w_ii − Σ_{j<i} w_ji/d_j [(1−ω) w_ij + ω Σ_{k>j} w_kj]                       (1)
///
/// With x̃ = D^½ x, L̃ = D^−½ L D^−½, Ũ likewise and e = d_W/d − 2, the product of (I+L̃)⁻¹ W̃ (I+Ũ)⁻¹ with p is
///
///     t = (I + Ũ)⁻¹ p,     q = t + (I + L̃)⁻¹ (p + e t)                                                           (2)
///
/// Where no two neighbours of an unknown are neighbours of each other, as on five-point and seven-point grids, all fill is
/// dropped, the factors have W's own entries off the diagonal, and for a symmetric W they are those of
/// modified_incomplete_cholesky.hpp. Elsewhere changes of the entries that are there are dropped, too.
///
/// Unknowns are kept by levels: one more than that of the neighbours before it. Those of a level don't wait for each other
/// (Saad, sect. 11.6.3).
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/krylov/modified_incomplete_cholesky.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam takes_any  also an unsymmetric W on a symmetric pattern, and one whose factors would have fill on W's own entries
template <class Scalar, bool takes_any>
class EisenstatForm {
 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Slot = typename Matrix::StorageIndex;

  /// False where this pattern isn't served.
  [[nodiscard]] bool analyze(const Matrix& W) {
    if (!fits(W)) return false;
    order(W);
    const auto n = static_cast<std::size_t>(W.cols());
    start_.assign(n + 1, 0);
    each_before(W, [this](Eigen::Index i, Eigen::Index, auto) { ++start_[at(place_[at(i)]) + 1]; });
    for (std::size_t k = 1; k <= n; ++k) start_[k] += start_[k - 1];
    column_.resize(at(start_[n]));
    l_.resize(column_.size());
    each_before(
        W, [this](Eigen::Index i, Eigen::Index j, auto) { column_[at(start_[at(place_[at(i)])]++)] = place_[at(j)]; });
    std::copy_backward(start_.begin(), start_.end() - 1, start_.end());
    start_[0] = 0;
    for (Vector* each : {&e_, &s_, &w_, &p_, &t_, &q_, &r_}) each->setZero(W.cols());
    u_.clear();
    return true;
  }
  enum class Found { definite, indefinite, unsymmetric };
  /// (1). What is unsymmetric or has an entry on the diagonal that isn't positive may not be served.
  [[nodiscard]] Found factorize(const Matrix& W) {
    constexpr Scalar omega = ModifiedIncompleteCholesky<Scalar>::omega;
    const Scalar tolerance = 64 * std::sqrt(std::numeric_limits<Scalar>::epsilon());
    const Slot *const outer = W.outerIndexPtr(), *const inner = W.innerIndexPtr();
    const Scalar* const w = W.valuePtr();
    is_symmetric_ = true;
    Vector &inverse = t_, &after = q_, &own = p_;  // 1/d_j, Σ_{k>j} w_kj and w_jj, in W's order
    for (Eigen::Index i = 0; i < W.cols(); ++i) {
      const Slot k = place_[at(i)];
      Slot p = outer[i], to = start_[at(k)];
      Scalar d{0};
      for (; inner[p] < i; ++p) {
        const Slot j = inner[p], transpose = next_[at(j)]++;
        if (is_symmetric_ && !(std::abs(w[p] - w[transpose]) <= tolerance * own[j])) {
          if (!takes_any) return Found::unsymmetric;
          is_symmetric_ = false;
          u_ = l_;
        }
        d -= w[p] * inverse[j] * ((1 - omega) * w[transpose] + omega * after[j]);
        l_[at(to)] = w[transpose];
        if (!is_symmetric_) u_[at(to)] = w[p];
        ++to;
      }
      own[i] = w[p];
      if (!(own[i] > Scalar{0})) return Found::indefinite;
      d += own[i];
      if (!(d > own[i] / 100)) d = own[i];
      inverse[i] = 1 / d;
      e_[k] = own[i] * inverse[i] - 2;
      s_[k] = std::sqrt(inverse[i]);
      next_[at(i)] = ++p;
      after[i] = 0;
      for (; p < outer[i + 1]; ++p) after[i] += w[p];
    }
    for (Slot k = 0; k < W.cols(); ++k)
      for (Slot p = start_[at(k)]; p < start_[at(k) + 1]; ++p) {
        const Scalar by = s_[k] * s_[column_[at(p)]];
        l_[at(p)] *= by;
        if (!is_symmetric_) u_[at(p)] *= by;
      }
    return is_symmetric_ ? Found::definite : Found::unsymmetric;
  }

 protected:
  [[nodiscard]] static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  /// Whether W's pattern is symmetric, with a full diagonal, and, unless any is taken, without triangles: entries (i, j), (j, k)
  /// and (i, k) of three unknowns, where factors would have fill.
  [[nodiscard]] bool fits(const Matrix& W) {
    const Slot *const outer = W.outerIndexPtr(), *const inner = W.innerIndexPtr();
    const auto has = [&](Slot i, Slot j) { return std::binary_search(inner + outer[j], inner + outer[j + 1], i); };
    for (Slot j = 0; j < W.cols(); ++j) {
      if (!has(j, j)) return false;
      for (Slot p = outer[j]; p < outer[j + 1]; ++p) {
        if (!has(j, inner[p])) return false;
        if (!takes_any && inner[p] > j)
          for (Slot q = p + 1; q < outer[j + 1]; ++q)
            if (has(inner[q], inner[p])) return false;
      }
    }
    return true;
  }
  /// f(i, j, w_ij) for j < i, row by row.
  static void each_before(const Matrix& W, auto&& f) {
    for (Eigen::Index i = 0; i < W.cols(); ++i)
      for (typename Matrix::InnerIterator w(W, i); w && w.row() < i; ++w) f(i, w.row(), w.value());
  }
  /// Places by levels, in W's order inside of one.
  void order(const Matrix& W) {
    next_.assign(at(W.cols()), 0);
    each_before(
        W, [this](Eigen::Index i, Eigen::Index j, auto) { next_[at(i)] = std::max(next_[at(i)], next_[at(j)] + 1); });
    std::vector<Slot> first(at(W.cols()) + 1, 0);
    for (const Slot level : next_) ++first[at(level) + 1];
    for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
    place_.resize(next_.size());
    for (std::size_t i = 0; i < next_.size(); ++i) place_[i] = first[at(next_[i])]++;
  }
  /// r ← (I + L̃)⁻¹ D^−½ r, and r·r
  [[nodiscard]] Scalar begin() {
    Scalar rr{0};
    const Slot* const start = start_.data();
    for (Eigen::Index k = 0; k < r_.size(); ++k) {
      Scalar here = s_[k] * r_[k];
      for (Slot p = start[k]; p < start[k + 1]; ++p) here -= l_[at(p)] * r_[column_[at(p)]];
      r_[k] = here;
      rr += here * here;
    }
    return rr;
  }
  /// Ũ's entries, by the slots of L̃'s transposes.
  [[nodiscard]] const Scalar* upper() const { return is_symmetric_ ? l_.data() : u_.data(); }

  std::vector<Slot> place_;           // of W's i-th unknown
  std::vector<Slot> next_;            // slot of w_kj that comes next, of column j
  std::vector<Slot> start_, column_;  // of L̃, row by row
  std::vector<Scalar> l_, u_;         // L̃; Ũᵀ, where it is another one
  Vector e_, s_, w_;                  // e, D^−½, weights times that
  Vector p_, t_, q_, r_;
  bool is_symmetric_ = true;
};

}}  // namespace phistep::PHISTEP_ABI
