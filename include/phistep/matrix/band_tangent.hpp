/// @file
/// K = ∂Ψ/∂r and C = ∂Ψ/∂v (or ∂Ψ/∂y) of a band matrix, in band storage. The band is found from the entries that arrive.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "phistep/core/arithmetic.hpp"
#include "phistep/core/version.hpp"
#include "phistep/simd/update.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The sink of a banded Jacobian. Entries beyond the band known so far wait until settle() widens it: once for each
/// pattern, after which nothing is allocated.
template <class Scalar, bool has_K, bool has_C>
class BandTangent {
 public:
  using Index = Eigen::Index;

  void resize(Index n, Index lower = 0, Index upper = 0) {
    n_ = n, lower_ = lower, upper_ = upper;
    if constexpr (has_K) K_.setZero(width(), n);
    if constexpr (has_C) C_.setZero(width(), n);
    outside_.clear();
  }
  void clear() {
    if constexpr (has_K) K_.setZero();
    if constexpr (has_C) C_.setZero();
    outside_.clear();
  }
  void position(Index i, Index j, Scalar x) {
    if constexpr (has_K) {
      if (is_inside(i, j)) K_(upper_ + i - j, j) += x;
      else outside_.push_back({i, j, x, Scalar{0}});
    }
  }
  void velocity(Index i, Index j, Scalar x) {
    if constexpr (has_C) {
      if (is_inside(i, j)) C_(upper_ + i - j, j) += x;
      else outside_.push_back({i, j, Scalar{0}, x});
    }
  }
  /// Makes room for (i, j).
  void include(Index i, Index j) {
    if (!is_inside(i, j)) outside_.push_back({i, j, Scalar{0}, Scalar{0}});
  }
  [[nodiscard]] bool is_finite() const {
    bool finite = true;
    if constexpr (has_K) finite = finite && all_finite(K_.data(), K_.size());
    if constexpr (has_C) finite = finite && all_finite(C_.data(), C_.size());
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
    const auto widen = [&](Matrix& band) {
      Matrix wider = Matrix::Zero(lower + upper + 1, n_);
      wider.middleRows(upper - upper_, width()) = band;
      band.swap(wider);
    };
    if constexpr (has_K) widen(K_);
    if constexpr (has_C) widen(C_);
    lower_ = lower, upper_ = upper;
    for (const Entry& entry : outside_) {
      if constexpr (has_K) K_(upper_ + entry.i - entry.j, entry.j) += entry.K;
      if constexpr (has_C) C_(upper_ + entry.i - entry.j, entry.j) += entry.C;
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
          out[i] += factor * K_(upper_ + i - j, j) * x[j];
  }

  /// The part −γ_f (C + γ_d K) of W.
  struct Part {
    const BandTangent& tangent;
    Scalar gamma_force, gamma_drift;
    [[nodiscard]] Scalar operator()(Index i, Index j) const {
      const Index at = j * tangent.width() + tangent.upper_ + i - j;
      if constexpr (has_K && has_C) return -gamma_force * (tangent.C_.data()[at] + gamma_drift * tangent.K_.data()[at]);
      else if constexpr (has_K) return (-gamma_force * gamma_drift) * tangent.K_.data()[at];
      else if constexpr (has_C) return -gamma_force * tangent.C_.data()[at];
      else return Scalar{0};
    }
  };
  /// The largest entry of K, 0 where there is none.
  [[nodiscard]] double largest_K() const {
    if constexpr (has_K) return largest(K_);
    else return 0;
  }

 private:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  template <int>
  struct Nothing {};
  struct Entry {
    Index i, j;
    Scalar K, C;
  };
  [[nodiscard]] bool is_inside(Index i, Index j) const { return i - j <= lower_ && j - i <= upper_; }

  Index n_ = 0, lower_ = 0, upper_ = 0;
  [[no_unique_address]] std::conditional_t<has_K, Matrix, Nothing<0>> K_;  // row upper + i − j, column j
  [[no_unique_address]] std::conditional_t<has_C, Matrix, Nothing<1>> C_;
  std::vector<Entry> outside_;
};

}  // namespace phistep::inline PHISTEP_ABI
