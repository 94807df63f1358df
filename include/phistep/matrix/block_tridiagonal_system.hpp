/// @file
/// The step's matrix W = M − γ_f C − γ_f γ_d K as a chain of b×b blocks: several unknowns a grid point in one dimension.
///
/// Block elimination without pivoting between blocks serves first. Where it can't be trusted (it says so: see
/// linear/block_tridiagonal_lu.hpp), and where an entry falls outside the blocks, a banded LU of the same W does, counted
/// in Statistics::fallbacks.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

#include "phistep/core/outcome.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/version.hpp"
#include "phistep/linear/block_tridiagonal_lu.hpp"
#include "phistep/matrix/banded_system.hpp"
#include "phistep/matrix/choice.hpp"
#include "phistep/matrix/dense_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// W = chain of b×b blocks; a last block that isn't full is completed by ones on the diagonal.
template <class Scalar, int b, bool has_K, bool has_C>
class BlockTridiagonalSystem : public Sizes {
 public:
  using Index = Eigen::Index;

  void resize(Index n) {
    band_.resize(n, 2 * b - 1, 2 * b - 1);
    lu_.resize((n + b - 1) / b);
    padded_.setZero(n % b == 0 ? 0 : lu_.blocks() * b);
    beyond_ = false;
  }

  void clear() {
    band_.clear();
    beyond_ = false;
  }
  void position(Index i, Index j, Scalar x) {
    beyond_ = beyond_ || !is_inside(i, j);
    band_.position(i, j, x);
  }
  void velocity(Index i, Index j, Scalar x) {
    beyond_ = beyond_ || !is_inside(i, j);
    band_.velocity(i, j, x);
  }
  void rate(Index i, Index j, Scalar x) { velocity(i, j, x); }
  [[nodiscard]] bool is_finite() const { return band_.is_finite(); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar gamma_drift, Statistics& statistics) {
    by_blocks_ = !beyond_ && assemble(masses, gamma_force, gamma_drift) && lu_.factorize();
    if (by_blocks_) {
      ++statistics.factorizations;
      return Outcome::success;
    }
    ++statistics.fallbacks;
    const Outcome outcome = band_.factorize(masses, gamma_force, gamma_drift, statistics);
    static_cast<Sizes&>(*this) = band_;
    return outcome;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    if (!by_blocks_) return band_.solve(x);
    if (padded_.size() == 0) {
      lu_.solve_in_place(x.data());
    } else {
      padded_.head(x.size()) = x;
      padded_.tail(padded_.size() - x.size()).setZero();
      lu_.solve_in_place(padded_.data());
      x = padded_.head(x.size());
    }
    return Outcome::success;
  }
  [[nodiscard]] BandWidth band(const auto& masses) { return band_.band(masses); }
  void for_each_tangent(auto&& f) const { band_.for_each_tangent(f); }
  void add_position_product(Scalar factor, const auto& x, auto& out) const {
    band_.add_position_product(factor, x, out);
  }

 private:
  [[nodiscard]] static bool is_inside(Index i, Index j) {
    const Index apart = i / b - j / b;
    return -1 <= apart && apart <= 1;
  }
  /// False where the masses have entries outside the blocks.
  [[nodiscard]] bool assemble(const auto& masses, Scalar gamma_force, Scalar gamma_drift) {
    const auto& tangent = band_.tangent();
    const Index n = tangent.rows(), blocks = lu_.blocks();
    const auto fill = [&](auto& to, Index k, Index l) {
      const Index rows = std::min<Index>(b, n - k * b), columns = std::min<Index>(b, n - l * b);
      const auto part = tangent.template block<b>(k * b, l * b, gamma_force, gamma_drift);
      if (rows == b && columns == b) {
        to = part;
      } else {
        to.setZero();
        to.topLeftCorner(rows, columns) = part.topLeftCorner(rows, columns);
      }
    };
    for (Index k = 0; k < blocks; ++k) {
      fill(lu_.diagonal(k), k, k);
      if (k > 0) fill(lu_.lower(k), k, k - 1);
      if (k + 1 < blocks) fill(lu_.upper(k), k, k + 1);
    }
    for (Index i = n % b; i > 0 && i < b; ++i) lu_.diagonal(blocks - 1)(i, i) = Scalar{1};
    bool inside = true;
    masses([&](Index i, Index j, auto m) {
      inside = inside && is_inside(i, j);
      if (inside) block(i / b, j / b)(i % b, j % b) += static_cast<Scalar>(m);
    });
    // Large off-diagonal blocks alone would make K's share look larger than it is: the careful side.
    Scalar largest{0};
    for (Index k = 0; k < blocks; ++k) largest = std::max(largest, lu_.diagonal(k).cwiseAbs().maxCoeff());
    measure(static_cast<double>(gamma_force * gamma_drift), tangent.largest_K(), static_cast<double>(largest));
    return inside;
  }
  [[nodiscard]] auto& block(Index k, Index l) { return l < k ? lu_.lower(k) : l > k ? lu_.upper(k) : lu_.diagonal(k); }

  BandedSystem<Scalar, has_K, has_C> band_;  // keeps K and C, and solves where the blocks can't
  BlockTridiagonalLu<Scalar, b> lu_;
  Eigen::Matrix<Scalar, Eigen::Dynamic, 1> padded_;  // the right-hand side of a chain whose last block isn't full
  bool beyond_ = false, by_blocks_ = false;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::block_tridiagonal, facts, Scalar, Solver, Force> {
  static_assert(facts.block > 0, "phistep: a block tridiagonal force must say its block: static constexpr int block");
  using type = BlockTridiagonalSystem<Scalar, facts.block, facts.has_K, facts.has_C>;
};

}}  // namespace phistep::PHISTEP_ABI
