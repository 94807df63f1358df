/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K, dense, diagonal, or of small dense blocks on the diagonal: a LinearSystem
/// (linear_system.hpp) that takes entries, and as most do multiplies with K,
///   add_position_product(a, x, out)          out += a K x
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/linear_system.hpp"
#include "phistep/step/matrix/small_dense_lu.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// W's rows by powers of two, 1 over their largest entries, columns in units of their unknowns: pivots are then chosen by what entries
/// are worth. Only where the unknowns' sizes differ, in the units given, by more than the digits wanted bear.
template <class Scalar, int n>
class RowScales {
 public:
  void resize(Eigen::Index size) {
    is_on_ = false;
    sizes_ = rows_ = decltype(rows_)::Ones(size);
  }
  /// @param weigh  weigh(x) puts 1 over the unknowns' sizes, about, into x; 0: not known   @param rtol  0: no digits are asked
  void begin(auto&& weigh, Scalar rtol) {
    if (is_on_ = rtol > 0 && sizes_.size() > 0; !is_on_) return;
    weigh(sizes_);
    const Scalar most = sizes_.maxCoeff(), least = (sizes_.array() > 0).select(sizes_, most).minCoeff();
    is_on_ = most > 0 && (sizes_.minCoeff() == 0 || std::numeric_limits<Scalar>::epsilon() * most > rtol * least);
    if (is_on_) sizes_ = (sizes_.array() > 0).select(least / sizes_.array(), Scalar{0});
  }
  void scale(auto& W) {
    if (!is_on_) return;
    const auto most = [&](Eigen::Index i) { return (W.row(i).transpose().array().abs() * sizes_.array()).maxCoeff(); };
    // One without a size gets more than that which the others give it: they are not solved by its row. What nothing makes is solved by
    // its own row: by another's, rounding would make something of it.
    for (bool grows = true; std::exchange(grows, false);)
      for (Eigen::Index i = 0; i < W.rows(); ++i)
        if (sizes_[i] == 0 && W(i, i) != 0) {
          sizes_[i] = 16 * most(i) / std::abs(W(i, i));
          grows = grows || sizes_[i] > 0;
        }
    for (Eigen::Index i = 0; i < W.rows(); ++i) {
      const Scalar own = std::ldexp(W(i, i), -std::numeric_limits<Scalar>::max_exponent / 4), made = most(i),
                   largest = made > 0 ? made : std::abs(own);
      rows_[i] = largest > 0 && std::isfinite(largest) ? std::ldexp(Scalar{1}, -std::ilogb(largest)) : Scalar{1};
      W.row(i) *= rows_[i];
    }
  }
  void scale_right(auto& x) const {
    if (is_on_) x.array() *= rows_.array();
  }

 private:
  Eigen::Matrix<Scalar, n, 1> sizes_, rows_;
  bool is_on_ = false;
};

/// Dense W.
template <class Scalar, int n, bool has_K, bool has_C>
class DenseSystem : public SystemDefaults {
 public:
  using Matrix = Eigen::Matrix<Scalar, n, n>;
  void resize(Eigen::Index size) {
    lu_.resize(size);
    tangents_.resize(size, size);
    rows_.resize(size);
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
    set(std::abs(static_cast<double>(gamma_force * gamma_drift)) * tangents_.largest_share(W), largest(W));
    ++statistics.factorizations;
    rows_.scale(W);
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    rows_.scale_right(x);
    lu_.solve_in_place(x);
    return Outcome::success;
  }
  /// Sets how the rows of the next factors are scaled.
  void scale_rows_by(auto&& weigh, Scalar rtol) { rows_.begin(weigh, rtol); }
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
  RowScales<Scalar, n> rows_;
};

/// Diagonal W: every component solves for itself. Off-diagonal entries never arrive here.
template <class Scalar, int n, bool has_K, bool has_C>
class DiagonalSystem : public SystemDefaults {
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
    set(std::abs(static_cast<double>(gamma_force * gamma_drift)) * tangents_.largest_share(inverse_),
        largest(inverse_));
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
  using type = DenseSystem<Scalar, facts.n, facts.has_K, facts.has_C>;
};
template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::diagonal, facts, Scalar, Solver, Force> {
  using type = DiagonalSystem<Scalar, facts.n, facts.has_K, facts.has_C>;
};

/// Block-diagonal W of d×d blocks, where no particle acts on another: each with an unrolled, pivoted LU of its own. Entries between
/// particles never arrive here. (Eight blocks side by side in vector registers, pivots chosen by selection, took 3 to 5 times as long.)
template <class Scalar, int d, bool has_K, bool has_C>
class LocalSystem : public SystemDefaults {
 public:
  void resize(Eigen::Index n) {
    const Eigen::Index particles = (n + d - 1) / d;
    tangents_.resize(particles * d * d);
    W_.setZero(particles * d * d);
    lu_.resize(static_cast<std::size_t>(particles));
    for (auto& lu : lu_) lu.resize(d);
    n_ = n;
    singular_ = -1;
  }

  void clear() { tangents_.clear(); }
  void position(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_K) tangents_.K[slot(i, j)] += x;
  }
  void velocity(Eigen::Index i, Eigen::Index j, Scalar x) {
    if constexpr (has_C) tangents_.C[slot(i, j)] += x;
  }
  void rate(Eigen::Index i, Eigen::Index j, Scalar x) { velocity(i, j, x); }
  [[nodiscard]] bool is_finite() const { return tangents_.is_finite(); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    W_ = tangents_.part(gamma_force, gamma_drift);
    masses([this](Eigen::Index i, Eigen::Index j, auto m) { W_[slot(i, j)] += static_cast<Scalar>(m); });
    for (Eigen::Index i = n_; i % d != 0; ++i) W_[slot(i, i)] = Scalar{1};  // rows beyond an incomplete last block
    ++statistics.factorizations;
    Scalar share{0}, most{0};
    for (std::size_t p = 0; p < lu_.size(); ++p) {
      const auto at = static_cast<Eigen::Index>(p) * d * d;
      const Scalar own = max_abs(lu_[p].matrix() = Eigen::Map<const Block>(W_.data() + at));
      most = std::max(most, own);
      // Particle by particle: a heavy one must not hide how stiff the others are.
      if constexpr (has_K) share = std::max(share, max_abs(Eigen::Map<const Block>(tangents_.K.data() + at)) / own);
      if (lu_[p].factorize()) continue;
      singular_ = static_cast<Eigen::Index>(p);
      return Outcome::singular_matrix;
    }
    set(static_cast<double>(std::abs(gamma_force * gamma_drift) * share), static_cast<double>(most));
    return Outcome::success;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    Scalar* at = x.data();
    const auto whole = static_cast<std::size_t>(n_ / d);
    for (std::size_t p = 0; p < whole; ++p, at += d) lu_[p].solve_in_place(Eigen::Map<Eigen::Matrix<Scalar, d, 1>>(at));
    if (n_ % d != 0) {
      Eigen::Matrix<Scalar, d, 1> one = Eigen::Matrix<Scalar, d, 1>::Zero();
      std::copy_n(at, n_ % d, one.data());
      lu_[whole].solve_in_place(one);
      std::copy_n(one.data(), n_ % d, at);
    }
    return Outcome::success;
  }
  [[nodiscard]] BandWidth band(const auto& /*masses*/) const { return {n_, d - 1, d - 1}; }
  void for_each_tangent(auto&& f) const {
    for (Eigen::Index j = 0; j < n_; ++j)
      for (Eigen::Index i = j / d * d; i < std::min<Eigen::Index>(n_, j / d * d + d); ++i) {
        const auto [K, C] = tangents_.at(slot(i, j));
        f(i, j, K, C);
      }
  }
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    if constexpr (has_K)
      for_each_tangent([&](Eigen::Index i, Eigen::Index j, Scalar K, Scalar) { out[i] += factor * K * x[j]; });
  }
  /// The particle whose block had no inverse at the last failure, −1 before.
  [[nodiscard]] Eigen::Index singular_particle() const { return singular_; }

 private:
  using Block = Eigen::Matrix<Scalar, d, d>;
  using Array = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  [[nodiscard]] static Eigen::Index slot(Eigen::Index i, Eigen::Index j) {
    return (i / d * d + j % d) * d + i % d;  // particle, column, row
  }

  Tangents<Array, has_K, has_C> tangents_;
  Array W_;
  std::vector<DenseLu<Scalar, d>> lu_;
  Eigen::Index n_ = 0, singular_ = -1;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::particles, facts, Scalar, Solver, Force> {
  using type = LocalSystem<Scalar, facts.block, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI
