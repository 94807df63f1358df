/// @file
/// Conjugate gradients with a modified incomplete Cholesky factorization in Eisenstat's form (eisenstat_form.hpp): the vector t
/// there is the direction of plain conjugate gradients, and P⁻¹r = D^−½ (t − β t_before).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

#include "phistep/core/version.hpp"
#include "phistep/krylov/eisenstat_form.hpp"
#include "phistep/krylov/methods.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Scalar, bool takes_any = false>
class EisenstatCg : public EisenstatForm<Scalar, takes_any> {
 public:
  using typename EisenstatForm<Scalar, takes_any>::Matrix;
  using typename EisenstatForm<Scalar, takes_any>::Vector;
  using typename EisenstatForm<Scalar, takes_any>::Slot;

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

 protected:
  using EisenstatForm<Scalar, takes_any>::at, EisenstatForm<Scalar, takes_any>::begin;
  using EisenstatForm<Scalar, takes_any>::place_, EisenstatForm<Scalar, takes_any>::start_,
      EisenstatForm<Scalar, takes_any>::column_, EisenstatForm<Scalar, takes_any>::l_;
  using EisenstatForm<Scalar, takes_any>::e_, EisenstatForm<Scalar, takes_any>::s_,
      EisenstatForm<Scalar, takes_any>::w_, EisenstatForm<Scalar, takes_any>::p_;
  using EisenstatForm<Scalar, takes_any>::t_, EisenstatForm<Scalar, takes_any>::q_,
      EisenstatForm<Scalar, takes_any>::r_;

 private:
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
  /// p ← r + β p, x ← x + α t, t ← (I + Ũ)⁻¹ p. Returns Σ w² (t − β t_before)².
  template <bool has_weights>
  [[nodiscard]] Scalar backward(Scalar beta, Scalar alpha, Scalar* x) {
    p_ = r_ + beta * p_;
    q_ = p_;
    Scalar sum{0};
    const Slot *const start = start_.data(), *const column = column_.data();
    const Scalar* const u = this->upper();
    Scalar *const t = t_.data(), *const q = q_.data();
    for (Eigen::Index k = r_.size(); k-- > 0;) {
      const Scalar here = q[k], before = t[k];
      for (Slot p = start[k]; p < start[k + 1]; ++p) q[column[p]] -= u[p] * here;
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
};

}}  // namespace phistep::PHISTEP_ABI
