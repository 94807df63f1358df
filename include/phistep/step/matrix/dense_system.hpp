/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K, dense or diagonal: a LinearSystem (linear_system.hpp) that takes entries,
/// and as most do multiplies with K,
///   add_position_product(a, x, out)          out += a K x
#pragma once

#include <Eigen/Core>

#include <cmath>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_lu.hpp"
#include "phistep/step/matrix/linear_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

/// Dense W. @tparam constant  the force is affine: its residuals are compared with ‖W‖
template <class Scalar, int n, bool has_K, bool has_C, bool constant = false>
class DenseSystem : public Sizes {
 public:
  using Matrix = Eigen::Matrix<Scalar, n, n>;
  void resize(Eigen::Index size) {
    lu_.resize(size);
    tangents_.resize(size, size);
  }

  void clear() { tangents_.clear(); }
  void position(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_K) tangents_.K(i, j) += x;
  }
  void velocity(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_C) tangents_.C(i, j) += x;
  }
  void rate(Eigen::Index i, Eigen::Index j, Scalar x) { velocity(i, j, x); }
  /// The whole of C at once, in place of clear() and rate().
  void set_rates(const Matrix& C) requires(!has_K && has_C && n != Eigen::Dynamic) { tangents_.C = C; }
  [[nodiscard]] bool is_finite() const { return tangents_.is_finite(); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    Matrix& W = lu_.matrix();
    W = tangents_.part(gamma_force, gamma_drift);
    masses([&W](Eigen::Index i, Eigen::Index j, auto m) { W(i, j) += static_cast<Scalar>(m); });
    set(std::abs(static_cast<double>(gamma_force * gamma_drift)) * largest_share_of(tangents_.K, W), largest_of(W));
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    lu_.solve_in_place(x);
    return Outcome::success;
  }
  /// out += factor K x
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    if constexpr (has_K) out.noalias() += factor * (tangents_.K * x);
  }
  /// f(i, j, K_ij, C_ij) for each entry
  void for_each_tangent(auto&& f) const {
    for (Eigen::Index j = 0; j < tangents_.rows(); ++j)
      for (Eigen::Index i = 0; i < tangents_.rows(); ++i) {
        const auto [K, C] = tangents_.at(i, j);
        f(i, j, K, C);
      }
  }

 private:
  Tangents<Matrix, has_K, has_C> tangents_;
  DenseLu<Scalar, n> lu_;
};

/// Diagonal W: every component solves for itself. Off-diagonal entries never arrive here.
template <class Scalar, int n, bool has_K, bool has_C>
class DiagonalSystem : public Sizes {
 public:
  using Vector = Eigen::Matrix<Scalar, n, 1>;
  void resize(Eigen::Index size) {
    tangents_.resize(size);
    inverse_.setZero(size);
  }

  void clear() { tangents_.clear(); }
  void position(Eigen::Index i, Eigen::Index, Scalar x) { tangents_.K[i] += x; }
  void velocity(Eigen::Index i, Eigen::Index, Scalar x) { tangents_.C[i] += x; }
  void rate(Eigen::Index i, Eigen::Index, Scalar x) { tangents_.C[i] += x; }
  [[nodiscard]] bool is_finite() const { return tangents_.is_finite(); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    inverse_ = tangents_.part(gamma_force, gamma_drift);
    masses([this](Eigen::Index i, Eigen::Index, auto m) { inverse_[i] += static_cast<Scalar>(m); });
    set(std::abs(static_cast<double>(gamma_force * gamma_drift)) * largest_share_of(tangents_.K, inverse_),
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
  [[nodiscard]] BandWidth band(const auto& /*masses*/) const { return {inverse_.size(), 0, 0}; }
  void for_each_tangent(auto&& f) const {
    for (Eigen::Index i = 0; i < inverse_.size(); ++i) f(i, i, tangents_.K[i], tangents_.C[i]);
  }
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    out.array() += factor * tangents_.K.array() * x.array();
  }

 private:
  Tangents<Vector, true, true> tangents_;
  Vector inverse_;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::dense, facts, Scalar, Solver, Force> {
  using type = DenseSystem<Scalar, facts.n, facts.has_K, facts.has_C, facts.constant>;
};
template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::diagonal, facts, Scalar, Solver, Force> {
  using type = DiagonalSystem<Scalar, facts.n, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI
