/// @file
/// Krylov methods for W x = b with a preconditioner P ≈ W, in workspaces of their own: nothing is allocated in a solve.
///
/// - conjugate gradients, for symmetric positive definite W and P (Y. Saad, Iterative Methods for Sparse Linear Systems, 2nd
///   ed., alg. 9.1)
/// - BiCGSTAB, for any W, five vectors (alg. 7.7), on P⁻¹W x = P⁻¹b
/// - GMRES(m), for any W, m + 1 vectors (alg. 9.4), on P⁻¹W x = P⁻¹b, least squares in the norm of the test
///
/// All stop by the size of the preconditioned residual z = P⁻¹(b − W x), which is about the error of x:
///
///     ‖z‖ ≤ max(absolute, relative ‖P⁻¹b‖),     ‖z‖² = 1/n Σ (w_i z_i)²                                          (1)
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

enum class KrylovMethod {
  conjugate_gradients,
  bicgstab,
  gmres,
  by_symmetry  ///< conjugate gradients while W is symmetric and fits their form (eisenstat.hpp), BiCGSTAB elsewhere
};

/// (1)
struct KrylovGoal {
  double absolute = 0, relative = 0;
  int max_iterations = 1000;
};
struct KrylovEnd {
  int iterations = 0;
  bool converged = false;
};

/// What the methods ask of W and P. `weights` are empty for ones. BiCGSTAB takes multiply_preconditioned(x, out, scratch) and
/// size(z, limit), a size that is right up to the limit, in their place.
template <class Operator, class Vector>
concept PreconditionedOperator = requires(Operator& W, const Vector& x, Vector& out) {
  W.multiply(x, out);      // out = W x
  W.precondition(x, out);  // out = P⁻¹ x
  { W.weights() } -> std::convertible_to<const Vector&>;
};

/// Σ w² a b / n
template <class Vector>
[[nodiscard]] double weighted_dot(const Vector& weights, const Vector& a, const Vector& b) {
  const auto n = static_cast<double>(std::max<Eigen::Index>(1, a.size()));
  if (weights.size() == 0) return static_cast<double>(a.dot(b)) / n;
  return static_cast<double>((weights.array().square() * a.array() * b.array()).sum()) / n;
}
template <class Vector>
[[nodiscard]] double weighted_norm(const Vector& weights, const Vector& a) {
  return std::sqrt(weighted_dot(weights, a, a));
}

/// resize(n) once; solve(W, goal, r, x) adds to x an approximation of W⁻¹ r. In: r = b − W x. r is lost.
template <class Scalar, KrylovMethod method>
class KrylovIteration;

template <class Scalar>
class KrylovIteration<Scalar, KrylovMethod::conjugate_gradients> {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  void resize(Eigen::Index n) {
    for (Vector* each : {&z_, &p_, &q_}) each->setZero(n);
  }
  [[nodiscard]] KrylovEnd solve(PreconditionedOperator<Vector> auto& W, const KrylovGoal& goal, Vector& r, auto& x) {
    W.precondition(r, z_);
    double size = weighted_norm(W.weights(), z_);
    const double limit = std::max(goal.absolute, goal.relative * size);
    p_ = z_;
    Scalar rz = r.dot(z_);
    for (int k = 0;; ++k) {
      if (size <= limit) return {k, true};
      if (k == goal.max_iterations) return {k, false};
      W.multiply(p_, q_);
      const Scalar curvature = p_.dot(q_);
      if (!(curvature > Scalar{0} && rz > Scalar{0})) return {k, false};  // not positive definite
      const Scalar alpha = rz / curvature;
      x += alpha * p_;
      r -= alpha * q_;
      W.precondition(r, z_);
      size = weighted_norm(W.weights(), z_);
      const Scalar before = rz;
      rz = r.dot(z_);
      p_ = z_ + (rz / before) * p_;
    }
  }

 private:
  Vector z_, p_, q_;
};

template <class Scalar>
class KrylovIteration<Scalar, KrylovMethod::bicgstab> {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  void resize(Eigen::Index n) {
    for (Vector* each : {&shadow_, &z_, &p_, &v_, &t_}) each->setZero(n);
  }
  [[nodiscard]] KrylovEnd solve(auto&& W, const KrylovGoal& goal, Vector& r, auto& x) {
    W.precondition(r, z_);
    double size = size_of(W, z_, std::numeric_limits<double>::infinity());
    const double limit = std::max(goal.absolute, goal.relative * size);
    shadow_ = p_ = z_;
    Scalar rho = shadow_.dot(z_);
    for (int k = 0;; ++k) {
      if (size <= limit) return {k, true};
      if (k == goal.max_iterations) return {k, false};
      apply(W, p_, v_, r);
      const Scalar along = shadow_.dot(v_);
      if (along == Scalar{0} || rho == Scalar{0}) return {k, false};
      const Scalar alpha = rho / along;
      x += alpha * p_;
      z_ -= alpha * v_;
      apply(W, z_, t_, r);
      const Scalar length = t_.squaredNorm();
      const Scalar omega = length > Scalar{0} ? t_.dot(z_) / length : Scalar{0};
      x += omega * z_;
      z_ -= omega * t_;
      size = size_of(W, z_, limit);
      const Scalar before = rho;
      rho = shadow_.dot(z_);
      if (!(omega != Scalar{0} && std::isfinite(rho))) return {k + 1, size <= limit};
      p_ = z_ + (rho / before) * (alpha / omega) * (p_ - omega * v_);
    }
  }

 private:
  static void apply(auto& W, const Vector& from, Vector& to, Vector& work) {
    if constexpr (requires { W.multiply_preconditioned(from, to, work); }) {
      W.multiply_preconditioned(from, to, work);
    } else {
      W.multiply(from, work);
      W.precondition(work, to);
    }
  }
  [[nodiscard]] static double size_of(auto& W, const Vector& z, double limit) {
    if constexpr (requires { W.size(z, limit); }) return W.size(z, limit);
    else return weighted_norm(W.weights(), z);
  }
  Vector shadow_, z_, p_, v_, t_;
};

template <class Scalar>
class KrylovIteration<Scalar, KrylovMethod::gmres> {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  static constexpr int restart = 30;  ///< m

  void resize(Eigen::Index n) {
    basis_.resize(n, restart + 1);
    one_.setZero(n), other_.setZero(n);
  }
  [[nodiscard]] KrylovEnd solve(PreconditionedOperator<Vector> auto& W, const KrylovGoal& goal, Vector& r, auto& x) {
    double limit = -1;
    for (int k = 0;;) {
      W.precondition(r, one_);
      const double size = weighted_norm(W.weights(), one_);
      if (limit < 0) limit = std::max(goal.absolute, goal.relative * size);
      if (size <= limit) return {k, true};
      if (k >= goal.max_iterations || !std::isfinite(size)) return {k, false};
      const int columns = build(W, size, limit, std::min(restart, goal.max_iterations - k));
      k += columns;
      combine(columns);
      x += one_;
      if (std::abs(g_[columns]) <= limit) return {k, true};
      W.multiply(one_, other_);
      r -= other_;
    }
  }

 private:
  /// Arnoldi from one_, whose norm is `size`; Givens rotations keep the least squares problem triangular.
  [[nodiscard]] int build(auto& W, double size, double limit, int most) {
    const Vector& w = W.weights();
    basis_.col(0) = one_ / static_cast<Scalar>(size);
    g_[0] = size;
    for (int j = 0; j < most; ++j) {
      one_ = basis_.col(j);
      W.multiply(one_, other_);
      W.precondition(other_, one_);
      for (int i = 0; i <= j; ++i) {
        other_ = basis_.col(i);
        h_[i][j] = weighted_dot(w, one_, other_);
        one_ -= static_cast<Scalar>(h_[i][j]) * other_;
      }
      const double rest = weighted_norm(w, one_);
      for (int i = 0; i < j; ++i) {
        const double above = h_[i][j];
        h_[i][j] = c_[i] * above + s_[i] * h_[i + 1][j];
        h_[i + 1][j] = c_[i] * h_[i + 1][j] - s_[i] * above;
      }
      const double length = std::hypot(h_[j][j], rest);
      c_[j] = length > 0 ? h_[j][j] / length : 1;
      s_[j] = length > 0 ? rest / length : 0;
      h_[j][j] = length;
      g_[j + 1] = -s_[j] * g_[j];
      g_[j] *= c_[j];
      if (std::abs(g_[j + 1]) <= limit || rest == 0) return j + 1;
      basis_.col(j + 1) = one_ / static_cast<Scalar>(rest);
    }
    return most;
  }
  /// one_ = V y, where y solves the triangular system.
  void combine(int columns) {
    one_.setZero();
    for (int j = columns - 1; j >= 0; --j) {
      double sum = g_[j];
      for (int k = j + 1; k < columns; ++k) sum -= h_[j][k] * y_[k];
      y_[j] = h_[j][j] != 0 ? sum / h_[j][j] : 0;
      one_ += static_cast<Scalar>(y_[j]) * basis_.col(j);
    }
  }

  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> basis_;
  Vector one_, other_;
  double h_[restart + 1][restart] = {}, c_[restart] = {}, s_[restart] = {}, g_[restart + 1] = {}, y_[restart] = {};
};

}}  // namespace phistep::PHISTEP_ABI
