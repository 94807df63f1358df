/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K, banded: one-dimensional grids and chains.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <vector>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/banded/banded_lu.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_system.hpp"
#include "phistep/step/matrix/linear_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y) of a band matrix, in band storage. The band is found from the entries that arrive.

/// The sink of a banded Jacobian. Entries beyond the band known so far wait until settle() widens it: once for each
/// pattern, after which nothing is allocated.
template <class Scalar, bool has_K, bool has_C>
class BandTangent {
 public:
  using Index = Eigen::Index;

  void resize(Index n) {
    n_ = n, lower_ = upper_ = 0;
    band_.resize(width(), n);
    outside_.clear();
  }
  void clear() {
    band_.clear();
    outside_.clear();
  }
  void position(Index i, Index j, Scalar x) {
    if constexpr (has_K) {
      if (is_inside(i, j)) band_.K(upper_ + i - j, j) += x;
      else outside_.push_back({i, j, x, Scalar{0}});
    }
  }
  void velocity(Index i, Index j, Scalar x) {
    if constexpr (has_C) {
      if (is_inside(i, j)) band_.C(upper_ + i - j, j) += x;
      else outside_.push_back({i, j, Scalar{0}, x});
    }
  }
  /// Makes room for (i, j).
  void include(Index i, Index j) {
    if (!is_inside(i, j)) outside_.push_back({i, j, Scalar{0}, Scalar{0}});
  }
  [[nodiscard]] bool is_finite() const {
    bool finite = band_.is_finite();
    for (const Entry& entry : outside_) finite = finite && std::isfinite(entry.K) && std::isfinite(entry.C);
    return finite;
  }

  /// Widens the band to what has arrived since.
  void settle() {
    if (outside_.empty()) return;
    Index lower = lower_, upper = upper_;
    for (const Entry& entry : outside_) {
      lower = std::max(lower, entry.i - entry.j);
      upper = std::max(upper, entry.j - entry.i);
    }
    band_.for_each([&](Matrix& band) {
      Matrix wider = Matrix::Zero(lower + upper + 1, n_);
      wider.middleRows(upper - upper_, width()) = band;
      band.swap(wider);
    });
    lower_ = lower, upper_ = upper;
    for (const Entry& entry : outside_) {
      if constexpr (has_K) band_.K(upper_ + entry.i - entry.j, entry.j) += entry.K;
      if constexpr (has_C) band_.C(upper_ + entry.i - entry.j, entry.j) += entry.C;
    }
    outside_ = {};
  }

  [[nodiscard]] Index rows() const { return n_; }
  [[nodiscard]] Index lower() const { return lower_; }
  [[nodiscard]] Index upper() const { return upper_; }
  [[nodiscard]] Index width() const { return lower_ + upper_ + 1; }
  /// out += factor K x
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    if constexpr (has_K)
      for (Index j = 0; j < n_; ++j)
        for (Index i = std::max<Index>(0, j - upper_); i <= std::min(n_ - 1, j + lower_); ++i)
          out[i] += factor * band_.K(upper_ + i - j, j) * x[j];
  }

  /// f(i, j, K_ij, C_ij) for each entry inside the band
  void for_each_entry(auto&& f) const {
    for (Index j = 0; j < n_; ++j)
      for (Index i = std::max<Index>(0, j - upper_); i <= std::min(n_ - 1, j + lower_); ++i) {
        const auto [K, C] = band_.at(upper_ + i - j, j);
        f(i, j, K, C);
      }
  }

  /// −γ_f (C + γ_d K): the entry (i, j) in row upper + i − j, column j.
  [[nodiscard]] auto part(Scalar gamma_force, Scalar gamma_drift) const { return band_.part(gamma_force, gamma_drift); }
  /// The largest entry of K, 0 where there is none.
  [[nodiscard]] double largest_K() const {
    if constexpr (has_K) return largest(band_.K);
    else return 0;
  }

 private:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  struct Entry {
    Index i, j;
    Scalar K, C;
  };
  [[nodiscard]] bool is_inside(Index i, Index j) const { return i - j <= lower_ && j - i <= upper_; }

  Index n_ = 0, lower_ = 0, upper_ = 0;
  Tangents<Matrix, has_K, has_C> band_;  // row upper + i − j, column j
  std::vector<Entry> outside_;
};

/// Banded W, factorized by LU with row pivoting. The bandwidths are those of the entries that arrive, masses included;
/// after the first factorization nothing is allocated unless one falls outside.
template <class Scalar, bool has_K, bool has_C>
class BandedSystem : public Sizes {
 public:
  using Index = Eigen::Index;
  using Tangent = BandTangent<Scalar, has_K, has_C>;

  void resize(Index n) {
    tangent_.resize(n);
    lu_ = {};
    knows_masses_ = false;
  }

  void clear() { tangent_.clear(); }
  void position(Index i, Index j, Scalar x) { tangent_.position(i, j, x); }
  void velocity(Index i, Index j, Scalar x) { tangent_.velocity(i, j, x); }
  void rate(Index i, Index j, Scalar x) { tangent_.velocity(i, j, x); }
  [[nodiscard]] bool is_finite() const { return tangent_.is_finite(); }
  [[nodiscard]] const Tangent& tangent() const { return tangent_; }

  /// The band of W, settled.
  [[nodiscard]] BandWidth band(const auto& masses) {
    if (!knows_masses_) masses([this](Index i, Index j, auto) { tangent_.include(i, j); });
    knows_masses_ = true;
    tangent_.settle();
    return {tangent_.rows(), tangent_.lower(), tangent_.upper()};
  }
  void for_each_tangent(auto&& f) const { tangent_.for_each_entry(f); }
  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    const auto [n, lower, upper] = band(masses);
    if (lu_.rows() != n || lu_.lower() != lower || lu_.upper() != upper) lu_.resize(n, lower, upper);
    else lu_.clear();
    lu_.band() = tangent_.part(gamma_force, gamma_drift);
    masses([this](Index i, Index j, auto m) { lu_.column(j)[i - j] += static_cast<Scalar>(m); });
    measure(static_cast<double>(gamma_force * gamma_drift), tangent_.largest_K(), largest(lu_.band()));
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    lu_.solve_in_place(x);
    return Outcome::success;
  }
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    tangent_.add_position_product(factor, x, out);
  }

 private:
  Tangent tangent_;
  BandedLu<Scalar> lu_;
  bool knows_masses_ = false;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::banded, facts, Scalar, Solver, Force> {
  using type = BandedSystem<Scalar, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI
