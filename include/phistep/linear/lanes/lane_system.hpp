/// @file
/// Factors of several shifted matrices with the same tangents, one a lane, for implicit Runge-Kutta methods:
///
///     W_l = λ_l/h M − C − h/λ_l K
///
/// The LU of one matrix (banded_lu.hpp) whose numbers are several, side by side: they share their rows' exchanges, and each
/// operation is a vector's, in n = 2 as in n = 200. One complex matrix after the other, by Eigen's LU, takes longer up to
/// about 100 unknowns, sparse ones always.
///
/// A `LaneSystem` for each kind of system (choice.hpp) takes the tangents out of that system and has, besides resize(n),
///     factorize(system, masses, shift, statistics) → Outcome
///     solve_in_place(x)                                  x ← W⁻¹ x, x a ComplexPack an unknown
///     add_position_product(system, a, x, out)            out += a K x, x of the positions, fewer than out's if at all
/// Here: dense ones and bands; linear/sparse/sparse_system.hpp has sparse ones.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <span>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/linear/banded/banded_lu.hpp"
#include "phistep/linear/lanes/complex_pack.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/linear_system.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What makes W_l of M, C and K, all of it multiplied by one power of two: W_ij = mass m − force C_ij + drift K_ij.
template <class Scalar, int lanes>
struct LaneShift {
  using Number = ComplexPack<Scalar, lanes>;
  using Real = typename Number::Real;
  Number mass, drift;
  Scalar force{1};

  template <MatrixFacts facts>
  [[nodiscard]] Number of_tangents(Scalar K, Scalar C) const {
    Number to{Real{Scalar{0}}, Real{Scalar{0}}};
    if constexpr (facts.has_C) to.re = Real{-force * C};
    if constexpr (facts.has_K) {
      to.re = to.re + drift.re * Real{K};
      to.im = drift.im * Real{K};
    }
    return to;
  }
  void add_mass(Number& to, Scalar m) const {
    to.re = to.re + Real{m} * mass.re;
    to.im = to.im + Real{m} * mass.im;
  }
};

template <SystemKind kind, MatrixFacts facts, class Scalar, int lanes>
class LaneSystem {
  static constexpr bool iterates = kind <= SystemKind::own;  // the first three
  static_assert(!iterates,
                "phistep: radau factorizes complex matrices, which Krylov iterations and solvers of the user's own "
                "don't: leave the linear solver to it (no newton<…>()), or take rodas5p");
  static_assert(iterates, "phistep: this force has a sparse Jacobian: #include <phistep/sparse.hpp>");

 public:
  static void resize(Eigen::Index) {}
  [[nodiscard]] static Outcome factorize(auto&&...) { return Outcome::singular_matrix; }
  static void solve_in_place(auto*) {}
  static void add_position_product(auto&&...) {}
};

/// Full matrices and bands, of a system that has for_each_tangent(f), which calls f(i, j, K, C) for each entry, and, if it is a
/// band, band(masses), what its width is. (Networks' edges are not there with shifts.)
template <SystemKind kind, MatrixFacts facts, class Scalar, int lanes>
  requires(SystemKind::diagonal <= kind && kind <= SystemKind::banded)
class LaneSystem<kind, facts, Scalar, lanes> {
  static constexpr bool is_full = kind == SystemKind::dense || kind == SystemKind::static_pattern;

 public:
  using Shift = LaneShift<Scalar, lanes>;
  using Number = typename Shift::Number;
  using Index = Eigen::Index;

  void resize(Index n) {
    if constexpr (is_full) lu_.resize(n);
    else lu_.resize(n, 0, 0);
  }
  [[nodiscard]] Outcome factorize(auto& system, const auto& masses, const Shift& shift, Statistics& statistics) {
    if constexpr (!is_full) {
      const BandWidth most = system.band(masses);
      if (lu_.lower() > most.lower || lu_.upper() > most.upper) lu_.resize(most.n, 0, 0);
      if (lu_.lower() < most.lower || lu_.upper() < most.upper) widen(system, masses);
      lu_.clear();
    }
    system.for_each_tangent([&](Index i, Index j, Scalar K, Scalar C) {
      if (is_full || is_inside(i, j)) lu_.column(j)[i - j] = shift.template of_tangents<facts>(K, C);
    });
    masses([&](Index i, Index j, auto m) { shift.add_mass(lu_.column(j)[i - j], static_cast<Scalar>(m)); });
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  void solve_in_place(Number* x) { lu_.solve_in_place(std::span{x, static_cast<std::size_t>(lu_.rows())}); }
  static void add_position_product(auto& system, Scalar factor, const auto& x, auto& out) {
    system.for_each_tangent([&](Index i, Index j, Scalar K, Scalar) {
      if (j < x.size()) out[static_cast<std::size_t>(i)] += factor * K * x.data()[j];
    });
  }

 private:
  [[nodiscard]] bool is_inside(Index i, Index j) const { return i - j <= lu_.lower() && j - i <= lu_.upper(); }
  /// To the diagonals that aren't zero: a chain of groups of b need not fill all 2b − 1 on either side.
  void widen(auto& system, const auto& masses) {
    Index lower = lu_.lower(), upper = lu_.upper();
    const auto include = [&](Index i, Index j) {
      lower = std::max(lower, i - j);
      upper = std::max(upper, j - i);
    };
    system.for_each_tangent([&](Index i, Index j, Scalar K, Scalar C) {
      if (K != Scalar{0} || C != Scalar{0}) include(i, j);
    });
    masses([&](Index i, Index j, auto) { include(i, j); });
    if (lower != lu_.lower() || upper != lu_.upper()) lu_.resize(lu_.rows(), lower, upper);
  }

  BandedLu<Number, is_full && 0 < facts.n && facts.n <= 8 ? facts.n : Eigen::Dynamic> lu_;
};

}}  // namespace phistep::PHISTEP_ABI
