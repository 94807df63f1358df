/// @file
/// K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y) of a band matrix, in band storage. The band is found from the entries that arrive.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <vector>

#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/matrix/linear_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

}}  // namespace phistep::PHISTEP_ABI
