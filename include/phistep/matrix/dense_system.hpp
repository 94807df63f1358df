/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K, dense or diagonal: its tangents, its factors, its solve.
///
/// K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y) are kept apart from W, so that a new γ costs no new Jacobian. Every system offers
///   resize(n)
///   clear, position/velocity/rate(i, j, x)   the sink of a Jacobian
///   factorize(masses, γ_f, γ_d, statistics)  W and its factors
///   solve(x)                                 x ← W⁻¹ x
///   drift_share()                            ‖γ_f γ_d K‖ / ‖W‖, row by row or of all: how much of r the solve sees
///   magnitude()                              ‖W‖, largest entry
///   archive(ar)                              the tangents for a checkpoint, from which factorize() makes W again
/// most
///   add_position_product(a, x, out)          out += a K x
/// and those that keep more than one Jacobian's tangents (`keeps_pattern`)
///   restore(masses, γ_f, γ_d, statistics)    after archive(): all that was there, even where no factors were
#pragma once

#include <Eigen/Core>

#include <cmath>

#include "phistep/core/arithmetic.hpp"
#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/linear/dense_solver.hpp"
#include "phistep/matrix/choice.hpp"
#include "phistep/simd/update.hpp"

namespace phistep::inline PHISTEP_ABI {

/// How large the entries of W are, and how much of them K makes.
class Sizes {
 public:
  void set(double drift_share, double magnitude) { drift_share_ = drift_share, magnitude_ = magnitude; }
  void measure(double gamma_squared, double largest_K, double largest_W) {
    magnitude_ = largest_W;
    drift_share_ = largest_W > 0 ? std::abs(gamma_squared) * largest_K / largest_W : 0;
  }
  [[nodiscard]] double drift_share() const { return drift_share_; }
  [[nodiscard]] double magnitude() const { return magnitude_; }

 private:
  double drift_share_ = 0, magnitude_ = 0;
};

[[nodiscard]] double largest_of(const auto& matrix) {
  if constexpr (requires { matrix.cwiseAbs(); }) return largest(matrix);
  else return 0;
}

/// The largest |K_ij|/|W_ij| of largest entries row by row: a heavy component must not hide how stiff the others are.
[[nodiscard]] double largest_share_of(const auto& K, const auto& W) {
  if constexpr (requires { K.cwiseAbs(); })
    if (K.size() > 0)
      return static_cast<double>(
          (K.cwiseAbs().rowwise().maxCoeff().array() / W.cwiseAbs().rowwise().maxCoeff().array()).maxCoeff());
  return 0;
}

/// Dense W. @tparam constant  one factorisation serves many solves: an inverse pays where n is small
/// @tparam stages  one serves several
template <class Scalar, int n, bool has_K, bool has_C, bool constant = false, bool stages = false>
class DenseSystem : public Sizes {
 public:
  using Matrix = Eigen::Matrix<Scalar, n, n>;
  void resize(Eigen::Index size) {
    lu_.resize(size);
    if constexpr (has_K) K_.setZero(size, size);
    if constexpr (has_C) C_.setZero(size, size);
  }

  void clear() {
    if constexpr (has_K) K_.setZero();
    if constexpr (has_C) C_.setZero();
  }
  void position(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_K) K_(i, j) += x;
  }
  void velocity(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_C) C_(i, j) += x;
  }
  void rate(Eigen::Index i, Eigen::Index j, Scalar x) { velocity(i, j, x); }
  /// The whole of C at once, in place of clear() and rate().
  void set_rates(const Eigen::Matrix<Scalar, n, n>& C) requires(!has_K && has_C && n != Eigen::Dynamic) { C_ = C; }
  [[nodiscard]] bool is_finite() const {
    bool finite = true;
    if constexpr (has_K) finite = finite && all_finite(K_.data(), K_.size());
    if constexpr (has_C) finite = finite && all_finite(C_.data(), C_.size());
    return finite;
  }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    Matrix& W = lu_.matrix();
    if constexpr (has_K && has_C) W = -gamma_force * (C_ + gamma_drift * K_);
    else if constexpr (has_K) W = (-gamma_force * gamma_drift) * K_;
    else W = -gamma_force * C_;
    masses([&W](Eigen::Index i, Eigen::Index j, auto m) { W(i, j) += static_cast<Scalar>(m); });
    // Only a drift's share and an affine force's residual are ever asked for.
    if constexpr (has_K || constant)
      set(std::abs(static_cast<double>(gamma_force * gamma_drift)) * largest_share_of(K_, W), largest_of(W));
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    lu_.solve_in_place(x);
    return Outcome::success;
  }
  /// out += factor K x
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    if constexpr (has_K) out.noalias() += factor * (K_ * x);
  }
  /// to = factor M − C − γK, for those who keep factors of their own
  void assemble(const auto& masses, Scalar factor, [[maybe_unused]] Scalar gamma, Matrix& to) const {
    if constexpr (has_K && has_C) to = -C_ - gamma * K_;
    else if constexpr (has_K) to = -gamma * K_;
    else to = -C_;
    masses([&to, factor](Eigen::Index i, Eigen::Index j, auto m) { to(i, j) += factor * static_cast<Scalar>(m); });
  }
  /// The tangents as they are.
  [[nodiscard]] const auto& K() const { return K_; }
  [[nodiscard]] const auto& C() const { return C_; }

 private:
  struct Absent {};
  [[no_unique_address]] std::conditional_t<has_K, Matrix, Absent> K_;
  [[no_unique_address]] std::conditional_t<has_C, Eigen::Matrix<Scalar, n, n>, Absent> C_;
  SmallDenseSolver<Scalar, n, constant ? Solves::many : stages ? Solves::several : Solves::few> lu_;
};

/// Diagonal W: every component solves for itself. Off-diagonal entries never arrive here.
template <class Scalar, int n, bool has_K, bool has_C>
class DiagonalSystem : public Sizes {
 public:
  using Vector = Eigen::Matrix<Scalar, n, 1>;
  void resize(Eigen::Index size) {
    K_.setZero(size);
    C_.setZero(size);
    inverse_.setZero(size);
  }

  void clear() {
    K_.setZero();
    C_.setZero();
  }
  void position(Eigen::Index i, Eigen::Index, Scalar x) { K_[i] += x; }
  void velocity(Eigen::Index i, Eigen::Index, Scalar x) { C_[i] += x; }
  void rate(Eigen::Index i, Eigen::Index, Scalar x) { C_[i] += x; }
  [[nodiscard]] bool is_finite() const { return all_finite(K_.data(), K_.size()) && all_finite(C_.data(), C_.size()); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    inverse_ = -gamma_force * (C_ + gamma_drift * K_);
    masses([this](Eigen::Index i, Eigen::Index, auto m) { inverse_[i] += static_cast<Scalar>(m); });
    set(std::abs(static_cast<double>(gamma_force * gamma_drift)) * largest_share_of(K_, inverse_),
        largest_of(inverse_));
    ++statistics.factorizations;
    for (Eigen::Index i = 0; i < inverse_.size(); ++i) {
      if (!(std::abs(inverse_[i]) > Scalar{0}) || !std::isfinite(inverse_[i])) return Outcome::singular_matrix;
      inverse_[i] = Scalar{1} / inverse_[i];
    }
    return Outcome::success;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    x.array() *= inverse_.array();
    return Outcome::success;
  }
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    out.array() += factor * K_.array() * x.array();
  }
  [[nodiscard]] const Vector& K() const { return K_; }
  [[nodiscard]] const Vector& C() const { return C_; }

 private:
  Vector K_, C_, inverse_;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::dense, facts, Scalar, Solver, Force> {
  using type = DenseSystem<Scalar, facts.n, facts.has_K, facts.has_C, facts.constant, facts.stages>;
};
template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::diagonal, facts, Scalar, Solver, Force> {
  using type = DiagonalSystem<Scalar, facts.n, facts.has_K, facts.has_C>;
};

}  // namespace phistep::inline PHISTEP_ABI
