/// @file
/// Conjugate gradients and BiCGSTAB with W between its own triangular factors, P⁻¹W at the price of the two triangular solves alone
/// (S. C. Eisenstat, SIAM J. Sci. Stat. Comput. 2 (1981) 1; Y. Saad, Iterative Methods for Sparse Linear Systems, 2nd ed.,
/// sect. 9.2.2). Of W = L + D_W + U,
///
///     P = (D + L) D⁻¹ (D + U),     d_i = w_ii − Σ_{j<i} w_ji/d_j [(1−ω) w_ij + ω Σ_{k>j} w_kj],     ω = 0.98         (1)
///
/// With x̃ = D^½ x, L̃ = D^−½ L D^−½, Ũ likewise and e = d_W/d − 2, the product of A = (I+L̃)⁻¹ W̃ (I+Ũ)⁻¹ with p is
///
///     t = (I + Ũ)⁻¹ p,     q = t + (I + L̃)⁻¹ (p + e t)                                                           (2)
///
/// These are modified incomplete factors (I. Gustafsson, BIT 18 (1978) 142): fill, and changes of entries that are there, are
/// dropped, and added to the diagonal. On grids, conjugate gradients then need iterations like the fourth root of their unknowns
/// in two dimensions, in place of the square root. A pivot that falls below a hundredth of W's own is replaced by W's.
///
/// A symmetric W is solved by conjugate gradients, where t is the direction of the plain ones, and P⁻¹r = D^−½ (t − β t_before); any
/// other one by BiCGSTAB on A (Saad, alg. 7.7).
///
/// Unknowns are kept by levels: each is one level above the highest of its neighbours before it. Those of one level don't wait
/// for each other (Saad, sect. 11.6.3).
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "phistep/linear/krylov/methods.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// analyze(W) for each pattern, factorize(W) for each W, then solves.
template <class Scalar>
class Eisenstat {
 public:
  using Matrix = Eigen::SparseMatrix<Scalar>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Slot = typename Matrix::StorageIndex;

  /// False where this pattern isn't served: it has to be symmetric, with a full diagonal.
  [[nodiscard]] bool analyze(const Matrix& W) {
    if (!fits(W)) return false;
    order(W);
    const auto n = static_cast<std::size_t>(W.cols());
    start_.assign(n + 1, 0);
    each_before(W, [this](Eigen::Index i, Eigen::Index) { ++start_[at(place_[at(i)]) + 1]; });
    for (std::size_t k = 1; k <= n; ++k) start_[k] += start_[k - 1];
    column_.resize(at(start_[n]));
    l_.resize(column_.size());
    each_before(W,
                [this](Eigen::Index i, Eigen::Index j) { column_[at(start_[at(place_[at(i)])]++)] = place_[at(j)]; });
    std::copy_backward(start_.begin(), start_.end() - 1, start_.end());
    start_[0] = 0;
    for (Vector* each : {&e_, &s_, &w_, &p_, &t_, &q_, &r_}) each->setZero(W.cols());
    u_.clear();
    return true;
  }
  /// (1). False where an entry on the diagonal isn't positive.
  [[nodiscard]] bool factorize(const Matrix& W) {
    constexpr Scalar omega = Scalar{98} / 100;
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
          is_symmetric_ = false;
          u_ = l_;
          bicgstab_.resize(W.cols());
        }
        d -= w[p] * inverse[j] * ((1 - omega) * w[transpose] + omega * after[j]);
        l_[at(to)] = w[transpose];
        if (!is_symmetric_) u_[at(to)] = w[p];
        ++to;
      }
      own[i] = w[p];
      if (!(own[i] > Scalar{0})) return false;
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
    return true;
  }
  /// Whether the last W was.
  [[nodiscard]] bool is_symmetric() const { return is_symmetric_; }

  /// x ← W⁻¹ x, until ‖P⁻¹r‖ is small in the weights' norm. @param weigh  weigh(w) sets them
  [[nodiscard]] KrylovEnd solve_within(const KrylovGoal& goal, auto& x, auto&& weigh) {
    weigh(q_);
    for (Eigen::Index i = 0; i < x.size(); ++i) w_[place_[at(i)]] = q_[i];
    w_.array() *= s_.array();
    const KrylovEnd end = is_symmetric_ ? conjugate_gradients(goal, x) : bicgstab(goal, x);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = q_[place_[at(i)]];
    return end;
  }
  /// x ← x + W⁻¹ r, until ‖P⁻¹r‖ is small. r is lost.
  [[nodiscard]] KrylovEnd solve(const KrylovGoal& goal, auto& r, auto& x) {
    w_ = s_;
    const KrylovEnd end = is_symmetric_ ? conjugate_gradients(goal, r) : bicgstab(goal, r);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += q_[place_[at(i)]];
    return end;
  }
  /// x ← P⁻¹ x
  void precondition(auto& x) {
    static_cast<void>(begin(x));
    solve_upper(r_);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = s_[place_[at(i)]] * t_[place_[at(i)]];
  }

 private:
  [[nodiscard]] static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  [[nodiscard]] static bool fits(const Matrix& W) {
    const Slot *const outer = W.outerIndexPtr(), *const inner = W.innerIndexPtr();
    const auto has = [&](Slot i, Slot j) { return std::binary_search(inner + outer[j], inner + outer[j + 1], i); };
    for (Slot j = 0; j < W.cols(); ++j) {
      if (!has(j, j)) return false;
      for (Slot p = outer[j]; p < outer[j + 1]; ++p)
        if (!has(j, inner[p])) return false;
    }
    return true;
  }
  /// f(i, j) for the entries with j < i, row by row.
  static void each_before(const Matrix& W, auto&& f) {
    for (Eigen::Index i = 0; i < W.cols(); ++i)
      for (typename Matrix::InnerIterator w(W, i); w && w.row() < i; ++w) f(i, w.row());
  }
  /// Sets place_: by levels, and within a level in W's order.
  void order(const Matrix& W) {
    next_.assign(at(W.cols()), 0);
    each_before(W, [this](Eigen::Index i, Eigen::Index j) { next_[at(i)] = std::max(next_[at(i)], next_[at(j)] + 1); });
    std::vector<Slot> first(at(W.cols()) + 1, 0);
    for (const Slot level : next_) ++first[at(level) + 1];
    for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
    place_.resize(next_.size());
    for (std::size_t i = 0; i < next_.size(); ++i) place_[i] = first[at(next_[i])]++;
  }
  /// r ← (I + L̃)⁻¹ D^−½ b, and r·r
  [[nodiscard]] Scalar begin(const auto& b) {
    for (Eigen::Index i = 0; i < b.size(); ++i) r_[place_[at(i)]] = b[i];
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

  /// q ← W⁻¹ x, by places. x keeps D^½ q by places meanwhile.
  [[nodiscard]] KrylovEnd conjugate_gradients(const KrylovGoal& goal, auto& x) {
    const auto count = static_cast<double>(std::max<Eigen::Index>(1, x.size()));
    Scalar rr = begin(x), beta{0}, alpha{0};
    x.setZero(), p_.setZero(), t_.setZero();
    double limit = -1;
    KrylovEnd end;
    for (;; ++end.iterations) {
      const double now = std::sqrt(static_cast<double>(backward(beta, alpha, x.data())) / count);
      if (limit < 0) limit = std::max(goal.absolute, goal.relative * now);
      end.converged = now <= limit;
      if (end.converged || end.iterations == goal.max_iterations) break;
      const Scalar curvature = forward(p_, q_);
      alpha = Scalar{0};
      if (!(curvature > Scalar{0} && rr > Scalar{0})) break;  // not positive definite
      alpha = rr / curvature;
      const Scalar before = rr;
      rr = move(alpha);
      beta = rr / before;
    }
    q_ = s_.cwiseProduct(x);
    return end;
  }
  /// p ← r + β p, x ← x + α t, t ← (I + Ũ)⁻¹ p. Returns Σ w² (t − β t_before)².
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
      const Scalar z = w_[k] * (here - beta * before);
      sum += z * z;
    }
    return sum;
  }
  /// (2) after t, p = x: out ← (I + L̃)⁻¹ (x + e t). Returns x·(out + t).
  [[gnu::always_inline]] inline Scalar forward(const Vector& x, Vector& out) const {
    Scalar sum{0};
    const Slot *const start = start_.data(), *const column = column_.data();
    const Scalar *const l = l_.data(), *const p = x.data(), *const t = t_.data(), *const e = e_.data();
    Scalar* const q = out.data();
    for (Eigen::Index k = 0; k < x.size(); ++k) {
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

  /// q ← W⁻¹ b, with q in the order of place_.
  [[nodiscard]] KrylovEnd bicgstab(const KrylovGoal& goal, const auto& b) {
    static_cast<void>(begin(b));
    q_.setZero();
    const KrylovEnd end = bicgstab_.solve(Between{*this}, goal, r_, q_);
    solve_upper(q_);
    q_ = s_.cwiseProduct(t_);
    return end;
  }
  /// A, for BiCGSTAB.
  struct Between {
    Eisenstat& all;
    void precondition(const Vector& x, Vector& out) const { out = x; }
    void multiply_preconditioned(const Vector& x, Vector& out, Vector& /*scratch*/) const { all.multiply(x, out); }
    [[nodiscard]] double size(const Vector& z, double limit) const {
      // The size by (I+L̃)⁻¹ alone is mostly the smaller one, and is known without a solve.
      if (const double alone = all.size_of(z); alone > limit) return alone;
      all.solve_upper(z);
      return all.size_of(all.t_);
    }
  };
  /// ‖D^−½ x‖ in the weights' norm
  [[nodiscard]] double size_of(const Vector& x) const {
    const Scalar sum = (w_.array() * x.array()).square().sum();
    return std::sqrt(static_cast<double>(sum) / static_cast<double>(x.size()));
  }
  /// t ← (I + Ũ)⁻¹ x
  void solve_upper(const Vector& x) {
    t_ = x;
    const Slot *const start = start_.data(), *const column = column_.data();
    const Scalar* const u = is_symmetric_ ? l_.data() : u_.data();  // by the slots of L̃'s transposes
    Scalar* const t = t_.data();
    for (Eigen::Index k = x.size(); k-- > 0;) {
      const Scalar here = t[k];
      for (Slot p = start[k]; p < start[k + 1]; ++p) t[column[p]] -= u[p] * here;
    }
  }
  /// out ← A x
  void multiply(const Vector& x, Vector& out) {
    solve_upper(x);
    forward(x, out);
    out += t_;
  }

  std::vector<Slot> place_;           // of W's i-th unknown
  std::vector<Slot> next_;            // slot of w_kj that comes next, of column j
  std::vector<Slot> start_, column_;  // of L̃, row by row
  std::vector<Scalar> l_, u_;         // L̃; Ũᵀ, where it is another one
  Vector e_, s_, w_;                  // e, D^−½, weights times that
  Vector p_, t_, q_, r_;
  KrylovIteration<Scalar, KrylovMethod::bicgstab> bicgstab_;
  bool is_symmetric_ = true;
};

}}  // namespace phistep::PHISTEP_ABI
