/// @file
/// Conjugate gradients with a modified incomplete Cholesky factorization, at the price of the two triangular solves alone
/// (S. C. Eisenstat, SIAM J. Sci. Stat. Comput. 2 (1981) 1; Y. Saad, Iterative Methods for Sparse Linear Systems, 2nd ed.,
/// sect. 9.2.2).
///
/// Where no two neighbours of an unknown are neighbours of each other, as on five-point and seven-point grids, all fill is
/// dropped, and the factors have W's own entries off the diagonal: of W = L + D_W + Lᵀ,
///
///     P = (D + L) D⁻¹ (D + Lᵀ),     d_i = w_ii − Σ_{j<i} w_ij/d_j [(1−ω) w_ij + ω Σ_{k>j} w_kj]                       (1)
///
/// the same D as in modified_incomplete_cholesky.hpp. With x̃ = D^½ x, L̃ = D^−½ L D^−½ and e = d_W/d − 2, the iteration is that
/// of conjugate gradients for (I+L̃)⁻¹ W̃ (I+L̃ᵀ)⁻¹, whose product is
///
///     t = (I + L̃ᵀ)⁻¹ p,     q = t + (I + L̃)⁻¹ (p + e t)                                                          (2)
///
/// t is the direction of plain conjugate gradients, and P⁻¹r = D^−½ (t − β t_before).
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
#include "phistep/krylov/methods.hpp"
#include "phistep/krylov/modified_incomplete_cholesky.hpp"

namespace phistep::inline PHISTEP_ABI {

template <class Scalar>
class EisenstatCg {
 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Slot = typename Matrix::StorageIndex;

  /// False where factors of this pattern have other entries than W, or it isn't symmetric.
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
    return true;
  }
  enum class Found { definite, indefinite, unsymmetric };
  /// (1)
  [[nodiscard]] Found factorize(const Matrix& W) {
    constexpr Scalar omega = ModifiedIncompleteCholesky<Scalar>::omega;
    const Scalar tolerance = 64 * std::sqrt(std::numeric_limits<Scalar>::epsilon());
    const Slot *const outer = W.outerIndexPtr(), *const inner = W.innerIndexPtr();
    const Scalar* const w = W.valuePtr();
    Vector &inverse = t_, &after = q_, &own = p_;  // 1/d_j, Σ_{k>j} w_kj and w_jj, in W's order
    for (Eigen::Index i = 0; i < W.cols(); ++i) {
      const Slot k = place_[at(i)];
      Slot p = outer[i], to = start_[at(k)];
      Scalar d{0};
      for (; inner[p] < i; ++p) {
        const Slot j = inner[p], transpose = next_[at(j)]++;
        if (!(std::abs(w[p] - w[transpose]) <= tolerance * own[j])) return Found::unsymmetric;
        d -= w[p] * inverse[j] * ((1 - omega) * w[p] + omega * after[j]);
        l_[at(to++)] = w[p];
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
      for (Slot p = start_[at(k)]; p < start_[at(k) + 1]; ++p) l_[at(p)] *= s_[k] * s_[column_[at(p)]];
    return Found::definite;
  }

  /// x ← W⁻¹ x, until ‖P⁻¹r‖ is small in the weights' norm. @param weigh  weigh(w) sets them
  [[nodiscard]] KrylovEnd solve_within(const KrylovGoal& goal, auto& x, auto&& weigh) {
    weigh(q_);
    for (Eigen::Index i = 0; i < x.size(); ++i) w_[place_[at(i)]] = q_[i];
    w_.array() *= s_.array();
    const KrylovEnd end = iterate<true>(goal, x);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = q_[place_[at(i)]];
    return end;
  }
  /// x ← x + W⁻¹ r, until ‖(I+L̃)⁻¹ D^−½ r‖ is small. r is lost.
  [[nodiscard]] KrylovEnd solve(const KrylovGoal& goal, auto& r, auto& x) {
    const KrylovEnd end = iterate<false>(goal, r);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += q_[place_[at(i)]];
    return end;
  }
  /// x ← P⁻¹ x
  void precondition(auto& x) {
    for (Eigen::Index i = 0; i < x.size(); ++i) r_[place_[at(i)]] = x[i];
    static_cast<void>(begin());
    p_.setZero(), t_.setZero();
    static_cast<void>(backward<false>(Scalar{0}, Scalar{0}, x.data()));
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = s_[place_[at(i)]] * t_[place_[at(i)]];
  }

 private:
  [[nodiscard]] static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  /// Whether W's pattern is symmetric, with a full diagonal, and without triangles: entries (i, j), (j, k) and (i, k) of three
  /// unknowns, where factors would have fill.
  [[nodiscard]] bool fits(const Matrix& W) {
    const Slot *const outer = W.outerIndexPtr(), *const inner = W.innerIndexPtr();
    const auto has = [&](Slot i, Slot j) { return std::binary_search(inner + outer[j], inner + outer[j + 1], i); };
    for (Slot j = 0; j < W.cols(); ++j) {
      if (!has(j, j)) return false;
      for (Slot p = outer[j]; p < outer[j + 1]; ++p) {
        if (!has(j, inner[p])) return false;
        if (inner[p] > j)
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

  /// q ← W⁻¹ x, by places. x keeps D^½ q by places meanwhile.
  template <bool has_weights>
  [[nodiscard]] KrylovEnd iterate(const KrylovGoal& goal, auto& x) {
    const auto count = static_cast<double>(std::max<Eigen::Index>(1, x.size()));
    for (Eigen::Index i = 0; i < x.size(); ++i) r_[place_[at(i)]] = x[i];
    Scalar rr = begin(), beta{0}, alpha{0};
    x.setZero(), p_.setZero(), t_.setZero();
    double limit = -1;
    KrylovEnd end;
    for (;; ++end.iterations) {
      Scalar size = rr;
      if constexpr (has_weights) size = backward<true>(beta, alpha, x.data());
      const double now = std::sqrt(static_cast<double>(size) / count);
      if (limit < 0) limit = std::max(goal.absolute, goal.relative * now);
      end.converged = now <= limit;
      if (end.converged || end.iterations == goal.max_iterations) break;
      if constexpr (!has_weights) static_cast<void>(backward<false>(beta, alpha, x.data()));
      const Scalar curvature = forward();
      alpha = Scalar{0};
      if (!(curvature > Scalar{0} && rr > Scalar{0})) break;  // not positive definite
      alpha = rr / curvature;
      const Scalar before = rr;
      rr = move(alpha);
      beta = rr / before;
    }
    q_ = s_.cwiseProduct(x);
    if constexpr (!has_weights) q_ += alpha * s_.cwiseProduct(t_);  // with weights, backward() has done it
    return end;
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
  /// p ← r + β p, x ← x + α t, t ← (I + L̃ᵀ)⁻¹ p. Returns Σ w² (t − β t_before)².
  template <bool has_weights>
  [[nodiscard]] Scalar backward(Scalar beta, Scalar alpha, Scalar* x) {
    p_ = r_ + beta * p_;
    q_ = p_;
    Scalar sum{0};
    const Slot *const start = start_.data(), *const column = column_.data();
    const Scalar* const l = l_.data();
    Scalar *const t = t_.data(), *const q = q_.data();
    for (Eigen::Index k = r_.size(); k-- > 0;) {
      const Scalar here = q[k], before = t[k];
      for (Slot p = start[k]; p < start[k + 1]; ++p) q[column[p]] -= l[p] * here;
      x[k] += alpha * before;
      t[k] = here;
      if constexpr (has_weights) {
        const Scalar z = w_[k] * (here - beta * before);
        sum += z * z;
      }
    }
    return sum;
  }
  /// q ← (I + L̃)⁻¹ (p + e t). Returns p·(q + t).
  [[nodiscard]] Scalar forward() {
    Scalar sum{0};
    const Slot *const start = start_.data(), *const column = column_.data();
    const Scalar *const l = l_.data(), *const p = p_.data(), *const t = t_.data(), *const e = e_.data();
    Scalar* const q = q_.data();
    for (Eigen::Index k = 0; k < r_.size(); ++k) {
      Scalar here = p[k] + e[k] * t[k];
      for (Slot m = start[k]; m < start[k + 1]; ++m) here -= l[m] * q[column[m]];
      q[k] = here;
      sum += p[k] * (here + t[k]);
    }
    return sum;
  }
  /// r ← r − α (q + t). Returns r·r.
  [[nodiscard]] Scalar move(Scalar alpha) {
    Scalar sum{0};
    const Scalar *const q = q_.data(), *const t = t_.data();
    Scalar* const r = r_.data();
    for (Eigen::Index k = 0; k < r_.size(); ++k) {
      r[k] -= alpha * (q[k] + t[k]);
      sum += r[k] * r[k];
    }
    return sum;
  }

  std::vector<Slot> place_;           // of W's i-th unknown
  std::vector<Slot> next_;            // slot of w_kj that comes next, of column j
  std::vector<Slot> start_, column_;  // of L̃, row by row
  std::vector<Scalar> l_;
  Vector e_, s_, w_;  // e, D^−½, weights times that
  Vector p_, t_, q_, r_;
};

}  // namespace phistep::inline PHISTEP_ABI
