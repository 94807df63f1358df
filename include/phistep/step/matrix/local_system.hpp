/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K where no particle acts on another: one small block a particle, each with
/// its own unrolled, pivoted LU; no sparse matrix, no index lists.
///
/// Eight particles side by side, with plain loops over the lanes that both compilers vectorise and pivots chosen by
/// selection, were slower: 3×3 blocks took 71 ns to invert against 15 ns for the LU here with SSE2, 25 against 8 with
/// AVX-512 (g++ 12); Eigen's 3×3 inverse took 16 (and picks no pivots).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <vector>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_lu.hpp"
#include "phistep/step/matrix/dense_system.hpp"
#include "phistep/step/matrix/linear_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Block-diagonal W of d×d blocks. Entries between particles never arrive here.
template <class Scalar, int d, bool has_K, bool has_C>
class LocalSystem : public Sizes {
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
    measure(static_cast<double>(gamma_force * gamma_drift), largest_of(tangents_.K), largest_of(W_));
    ++statistics.factorizations;
    for (std::size_t p = 0; p < lu_.size(); ++p) {
      lu_[p].matrix() = Eigen::Map<const Block>(W_.data() + static_cast<Eigen::Index>(p) * d * d);
      if (lu_[p].factorize()) continue;
      singular_ = static_cast<Eigen::Index>(p);
      return Outcome::singular_matrix;
    }
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
  /// out += factor K x
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
