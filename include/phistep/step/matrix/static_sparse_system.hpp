/// @file
/// The step's matrix W = M − γC of a first-order state of few unknowns whose force names the pattern of its Jacobian:
///
///     static constexpr auto jacobian_pattern = phistep::entries({{0, 0}, {0, 1}, {1, 0}});     // (row, column)
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

#include "phistep/base/numbers/finite_witness.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_system.hpp"
#include "phistep/step/matrix/static_sparse_lu.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A force's `jacobian_pattern` under the name that StaticSparseLu knows.
template <class Force>
struct PatternOf {
  static constexpr auto pattern = Force::jacobian_pattern;
};
/// Whether a force names a pattern that spares at least half of a dense elimination's n³/3 products. Up to 8 rows a dense
/// one costs little.
template <class Force, int n>
inline constexpr bool has_sparse_pattern = false;
template <class Force, int n>
  requires(n > 8 && n <= small_dense_limit && requires { Force::jacobian_pattern.size(); })
inline constexpr bool has_sparse_pattern<Force, n> =
    6 * EliminationPlan<n>{Force::jacobian_pattern}.products <= n * n * n;

/// See DenseSystem. @tparam constant  the force is affine: its residuals are compared with ‖W‖
template <class Scalar, int n, class Pattern, bool constant>
class StaticSparseSystem : public Sizes {
  using Lu = StaticSparseLu<Scalar, n, Pattern>;

 public:
  void resize(Eigen::Index) {
    clear();
    looked_ = false;
  }

  void clear() { C_.fill(Scalar{0}); }
  /// @throws std::invalid_argument where x isn't zero outside of the pattern
  [[gnu::always_inline]] void rate(Eigen::Index i, Eigen::Index j, Scalar x) {
    const int slot = Lu::plan(static_cast<int>(i), static_cast<int>(j));
    if (slot >= 0) C_[static_cast<std::size_t>(slot)] += x;
    else if (x != 0) refuse(i, j);
  }
  void velocity(Eigen::Index i, Eigen::Index j, Scalar x) { rate(i, j, x); }
  void position(Eigen::Index, Eigen::Index, Scalar) {}
  /// The whole of C at once. @throws std::invalid_argument as rate() does, if the first one breaks the pattern
  void set_rates(const Eigen::Matrix<Scalar, n, n>& C) {
    if (!std::exchange(looked_, true))
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          if (Lu::plan(i, j) < 0 && C(i, j) != 0) refuse(i, j);
    [&]<int... s>(std::integer_sequence<int, s...>) { ((C_[s] = C.data()[places[s]]), ...); }
    (std::make_integer_sequence<int, Lu::slots>{});
  }
  [[nodiscard]] bool is_finite() const { return all_finite(C_.data(), Lu::slots); }

  [[nodiscard]] Outcome factorize(const auto& masses, Scalar gamma_force, Scalar, Statistics& statistics) {
    ++statistics.factorizations;
    const bool regular = lu_.factorize([&](auto& W) {
      for (std::size_t s = 0; s < W.size(); ++s) W[s] = -gamma_force * C_[s];
      masses([&W](Eigen::Index i, Eigen::Index, auto m) { W[static_cast<std::size_t>(i)] += static_cast<Scalar>(m); });
      if constexpr (constant)
        set(0, static_cast<double>(std::abs(*std::max_element(
                   W.begin(), W.end(), [](Scalar a, Scalar b) { return std::abs(a) < std::abs(b); }))));
    });
    return regular ? Outcome::success : Outcome::singular_matrix;
  }
  [[nodiscard]] Outcome solve(auto& x) {
    lu_.solve_in_place(x);
    return Outcome::success;
  }
  static void add_position_product(Scalar, const auto&, auto&) {}
  /// f(i, j, 0, C_ij) for each entry, zero outside the pattern
  void for_each_tangent(auto&& f) const {
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int slot = Lu::plan(i, j);
        f(i, j, Scalar{0}, slot >= 0 ? C_[static_cast<std::size_t>(slot)] : Scalar{0});
      }
  }

 private:
  /// Where a slot lies in a matrix by columns.
  static constexpr auto places = [] {
    std::array<int, static_cast<std::size_t>(Lu::slots)> all{};
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (Lu::plan(i, j) >= 0) all[static_cast<std::size_t>(Lu::plan(i, j))] = i + j * n;
    return all;
  }();
  [[noreturn, gnu::cold, gnu::noinline]] static void refuse(Eigen::Index i, Eigen::Index j) {
    throw std::invalid_argument("phistep: the force's Jacobian has an entry (" + std::to_string(i) + ", " +
                                std::to_string(j) + ") that its jacobian_pattern doesn't have");
  }

  typename Lu::Values C_{};
  Lu lu_;
  bool looked_ = false;
};

template <MatrixFacts facts, class Scalar, class Solver, class Force>
struct SystemFor<SystemKind::static_pattern, facts, Scalar, Solver, Force> {
  using type = StaticSparseSystem<Scalar, facts.n, PatternOf<Force>, facts.constant>;
};

}}  // namespace phistep::PHISTEP_ABI
