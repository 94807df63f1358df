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
#include "phistep/linear/banded/banded_lu.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_system.hpp"
#include "phistep/step/matrix/linear_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Banded W, factorized by LU with row pivoting. The bandwidths are those of the entries that arrive, masses included: entries
/// beyond the band known so far wait until the next factorization widens it. Unless there are some, it allocates nothing.
template <class Scalar, bool has_K, bool has_C>
class BandedSystem : public SystemDefaults {
 public:
  using Index = Eigen::Index;

  void resize(Index n) {
    n_ = n, lower_ = upper_ = 0;
    tangents_.resize(width(), n);
    outside_.clear();
    lu_ = {};
    knows_masses_ = false;
  }
  [[nodiscard]] Index lower() const { return lower_; }
  [[nodiscard]] Index upper() const { return upper_; }

  void clear() {
    tangents_.clear();
    outside_.clear();
  }
  void position(Index i, Index j, Scalar x) {
    if constexpr (has_K) {
      if (is_inside(i, j)) tangents_.K(upper_ + i - j, j) += x;
      else outside_.push_back({i, j, x, Scalar{0}});
    }
  }
  void velocity(Index i, Index j, Scalar x) {
    if constexpr (has_C) {
      if (is_inside(i, j)) tangents_.C(upper_ + i - j, j) += x;
      else outside_.push_back({i, j, Scalar{0}, x});
    }
  }
  void rate(Index i, Index j, Scalar x) { velocity(i, j, x); }
  [[nodiscard]] bool is_finite() const {
    bool finite = tangents_.is_finite();
    for (const Entry& entry : outside_) finite = finite && std::isfinite(entry.K) && std::isfinite(entry.C);
    return finite;
  }

  /// The band of W, widened to what has arrived.
  [[nodiscard]] BandWidth band(const auto& masses) {
    if (!knows_masses_)
      masses([this](Index i, Index j, auto) {
        if (!is_inside(i, j)) outside_.push_back({i, j, Scalar{0}, Scalar{0}});
      });
    knows_masses_ = true;
    if (!outside_.empty()) widen();
    return {n_, lower_, upper_};
  }
  /// f(i, j, K_ij, C_ij) for each entry inside the band
  void for_each_tangent(auto&& f) const {
    for_each_place([&](Index i, Index j) {
      const auto [K, C] = tangents_.at(upper_ + i - j, j);
      f(i, j, K, C);
    });
  }
  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    const auto [n, lower, upper] = band(masses);
    if (lu_.rows() != n || lu_.lower() != lower || lu_.upper() != upper) lu_.resize(n, lower, upper);
    else lu_.clear();
    lu_.band() = tangents_.part(gamma_force, gamma_drift);
    masses([this](Index i, Index j, auto m) { lu_.column(j)[i - j] += static_cast<Scalar>(m); });
    double share = 0;
    if constexpr (has_K)
      for (Index j = 0; j < n; ++j) {
        // Column by column: a heavy component must not hide how stiff the others are.
        const Scalar *const K = tangents_.K.col(j).data(), *const W = lu_.column(j) - upper;
        Scalar of_K{0}, of_W{0};
        for (Index i = 0; i < width(); ++i)
          of_K = std::max(of_K, std::abs(K[i])), of_W = std::max(of_W, std::abs(W[i]));
        if (of_W > Scalar{0}) share = std::max(share, static_cast<double>(of_K / of_W));
      }
    set(std::abs(static_cast<double>(gamma_force * gamma_drift)) * share, largest(lu_.band()));
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    lu_.solve_in_place(x);
    return Outcome::success;
  }
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    if constexpr (has_K)
      for_each_place([&](Index i, Index j) { out[i] += factor * tangents_.K(upper_ + i - j, j) * x[j]; });
  }

 private:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  struct Entry {
    Index i, j;
    Scalar K, C;
  };
  [[nodiscard]] Index width() const { return lower_ + upper_ + 1; }
  [[nodiscard]] bool is_inside(Index i, Index j) const { return i - j <= lower_ && j - i <= upper_; }
  void for_each_place(auto&& f) const {
    for (Index j = 0; j < n_; ++j)
      for (Index i = std::max<Index>(0, j - upper_); i <= std::min(n_ - 1, j + lower_); ++i) f(i, j);
  }
  /// To the entries outside.
  void widen() {
    Index lower = lower_, upper = upper_;
    for (const Entry& entry : outside_) {
      lower = std::max(lower, entry.i - entry.j);
      upper = std::max(upper, entry.j - entry.i);
    }
    tangents_.for_each([&](Matrix& band) {
      Matrix wider = Matrix::Zero(lower + upper + 1, n_);
      wider.middleRows(upper - upper_, width()) = band;
      band.swap(wider);
    });
    lower_ = lower, upper_ = upper;
    for (const Entry& entry : outside_) {
      if constexpr (has_K) tangents_.K(upper_ + entry.i - entry.j, entry.j) += entry.K;
      if constexpr (has_C) tangents_.C(upper_ + entry.i - entry.j, entry.j) += entry.C;
    }
    outside_ = {};
  }

  Index n_ = 0, lower_ = 0, upper_ = 0;
  Tangents<Matrix, has_K, has_C> tangents_;  // in band storage: (i, j) in row upper + i − j, column j
  std::vector<Entry> outside_;
  BandedLu<Scalar> lu_;
  bool knows_masses_ = false;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::banded, facts, Scalar, Solver, Force> {
  using type = BandedSystem<Scalar, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI
