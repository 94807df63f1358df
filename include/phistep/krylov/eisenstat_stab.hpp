/// @file
/// W between its own triangular factors (eisenstat_form.hpp): conjugate gradients while W is symmetric, BiCGSTAB elsewhere (Y. Saad,
/// Iterative Methods for Sparse Linear Systems, 2nd ed., alg. 7.7), on A = (I+L̃)⁻¹ W̃ (I+Ũ)⁻¹.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

#include "phistep/core/version.hpp"
#include "phistep/krylov/eisenstat.hpp"
#include "phistep/krylov/methods.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Scalar>
class EisenstatStab : public EisenstatCg<Scalar, true> {
  using Cg = EisenstatCg<Scalar, true>;

 public:
  using typename Cg::Vector;

  /// x ← W⁻¹ x, until ‖P⁻¹r‖ is small in the weights' norm. @param weigh  weigh(w) sets them
  [[nodiscard]] KrylovEnd solve_within(const KrylovGoal& goal, auto& x, auto&& weigh) {
    if (is_symmetric_) return Cg::solve_within(goal, x, weigh);
    weigh(q_);
    for (Eigen::Index i = 0; i < x.size(); ++i) w_[place_[at(i)]] = q_[i];
    const KrylovEnd end = iterate(goal, x);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = t_[place_[at(i)]];
    return end;
  }
  /// x ← x + W⁻¹ r, until ‖P⁻¹r‖ is small. r is lost.
  [[nodiscard]] KrylovEnd solve(const KrylovGoal& goal, auto& r, auto& x) {
    if (is_symmetric_) return Cg::solve(goal, r, x);
    w_.setOnes();
    const KrylovEnd end = iterate(goal, r);
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += t_[place_[at(i)]];
    return end;
  }

 private:
  using Cg::at, Cg::begin, Cg::place_, Cg::start_, Cg::column_, Cg::l_;
  using Cg::e_, Cg::s_, Cg::w_, Cg::p_, Cg::t_, Cg::q_, Cg::r_, Cg::is_symmetric_;

  /// t ← W⁻¹ b, by places.
  [[nodiscard]] KrylovEnd iterate(const KrylovGoal& goal, const auto& b) {
    for (Eigen::Index i = 0; i < b.size(); ++i) r_[place_[at(i)]] = b[i];
    Scalar rho = begin();
    sum_.setZero(r_.size());
    v_.resize(r_.size());
    shadow_ = p_ = r_;
    double limit = -1;
    KrylovEnd end;
    for (;; ++end.iterations) {
      // Of a residual the size by (I+L̃)⁻¹ alone is mostly the smaller one, and is known without a solve.
      if (limit < 0 || size_of(r_) <= limit) {
        solve_upper(r_);
        const double now = size_of(t_);
        if (limit < 0) limit = std::max(goal.absolute, goal.relative * now);
        end.converged = now <= limit;
        if (end.converged) break;
      }
      if (end.iterations == goal.max_iterations) break;
      multiply(p_, v_);
      const Scalar along = shadow_.dot(v_);
      if (along == Scalar{0} || rho == Scalar{0}) break;
      const Scalar alpha = rho / along;
      r_ -= alpha * v_;
      multiply(r_, q_);
      const Scalar length = q_.squaredNorm(), omega = length > Scalar{0} ? q_.dot(r_) / length : Scalar{0};
      sum_ += alpha * p_ + omega * r_;
      r_ -= omega * q_;
      const Scalar before = rho;
      rho = shadow_.dot(r_);
      if (!(omega != Scalar{0} && std::isfinite(rho))) break;
      p_ = r_ + (rho / before) * (alpha / omega) * (p_ - omega * v_);
    }
    solve_upper(sum_);
    t_.array() *= s_.array();
    return end;
  }
  /// ‖D^−½ x‖ in the weights' norm
  [[nodiscard]] double size_of(const Vector& x) const {
    const Scalar sum = (w_.array() * s_.array() * x.array()).square().sum();
    return std::sqrt(static_cast<double>(sum) / static_cast<double>(x.size()));
  }
  /// t ← (I + Ũ)⁻¹ x
  void solve_upper(const Vector& x) {
    t_ = x;
    const auto *const start = start_.data(), *const column = column_.data();
    const Scalar* const u = this->upper();
    Scalar* const t = t_.data();
    for (Eigen::Index k = x.size(); k-- > 0;) {
      const Scalar here = t[k];
      for (auto p = start[k]; p < start[k + 1]; ++p) t[column[p]] -= u[p] * here;
    }
  }
  /// out ← A x
  void multiply(const Vector& x, Vector& out) {
    solve_upper(x);
    const auto *const start = start_.data(), *const column = column_.data();
    const Scalar *const l = l_.data(), *const p = x.data(), *const t = t_.data(), *const e = e_.data();
    Scalar* const q = out.data();
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      Scalar here = p[k] + e[k] * t[k];
      for (auto m = start[k]; m < start[k + 1]; ++m) here -= l[m] * q[column[m]];
      q[k] = here;
    }
    out += t_;
  }

  Vector shadow_, v_, sum_;
};

}}  // namespace phistep::PHISTEP_ABI
