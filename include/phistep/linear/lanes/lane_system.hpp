/// @file
/// Factors of several shifted matrices with the same tangents, one a lane, for implicit Runge-Kutta methods:
///
///     W_l = λ_l/h M − C − h/λ_l K
///
/// A `LaneSystem` for each kind of system (choice.hpp) takes the tangents out of that system and has, besides resize(n),
///     factorize(system, masses, shift, statistics) → Outcome
///     solve_in_place(x)                                  x ← W⁻¹ x, x a ComplexPack an unknown
///     add_position_product(system, a, x, out)            out += a K x, x of the positions
/// Here: dense ones and bands; sparse_lane_system.hpp has sparse ones.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/lanes/lane_banded_lu.hpp"
#include "phistep/linear/lanes/lane_lu.hpp"
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/tangents.hpp"

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

/// Few unknowns, known at compile time: there, zeros are cheaper than looking for them.
inline constexpr int small_lanes = 32;

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

/// Dense tangents, or few unknowns.
template <MatrixFacts facts, class Scalar, int lanes>
class DenseLaneSystem {
 public:
  using Shift = LaneShift<Scalar, lanes>;
  using Number = typename Shift::Number;

  void resize(Eigen::Index n) {
    lu_.resize(n);
    n_ = static_cast<int>(n);
  }
  [[nodiscard]] Outcome factorize(auto& system, const auto& masses, const Shift& shift, Statistics& statistics) {
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < n_; ++j)
        lu_(i, j) = shift.template of_tangents<facts>(entry<facts.has_K>(system.K(), i, j),
                                                      entry<facts.has_C>(system.C(), i, j));
    masses([&](auto i, auto j, auto m) {
      shift.add_mass(lu_(static_cast<int>(i), static_cast<int>(j)), static_cast<Scalar>(m));
    });
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  void solve_in_place(Number* x) { lu_.solve_in_place(x); }
  void add_position_product(auto& system, Scalar factor, const auto& x, auto& out) const {
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < static_cast<int>(x.size()); ++j)
        out[static_cast<std::size_t>(i)] += factor * entry<facts.has_K>(system.K(), i, j) * x.data()[j];
  }

 private:
  /// Of a matrix, or of one that is kept as its diagonal; a force may ignore v.
  template <bool is_there>
  [[nodiscard]] static Scalar entry(const auto& matrix, int i, int j) {
    if constexpr (!is_there) return Scalar{0};
    else if constexpr (std::remove_cvref_t<decltype(matrix)>::IsVectorAtCompileTime && facts.n != 1)
      return i == j ? matrix[i] : Scalar{0};
    else return matrix(i, j);
  }

  LaneLu<Scalar, facts.n, lanes> lu_;
  int n_ = 0;
};

/// Positions, of which there may be fewer than unknowns.
template <class Vector>
struct ZerosBeyond {
  const Vector& x;
  [[nodiscard]] auto operator[](Eigen::Index i) const {
    return i < x.size() ? x.data()[i] : typename Vector::Scalar{0};
  }
};
template <class Vector>
ZerosBeyond(const Vector&) -> ZerosBeyond<Vector>;
/// out += factor K x, x of the positions.
template <class Scalar>
void add_padded_product(auto& system, Scalar factor, const auto& x, auto& out) {
  Eigen::Map<Eigen::Matrix<Scalar, Eigen::Dynamic, 1>> to(out.data(), static_cast<Eigen::Index>(out.size()));
  system.add_position_product(factor, ZerosBeyond{x}, to);
}

/// A band: of a system that has band(masses), what its width() is, and for_each_tangent(f), which calls f(i, j, K, C).
template <MatrixFacts facts, class Scalar, int lanes>
class BandedLaneSystem {
 public:
  using Shift = LaneShift<Scalar, lanes>;
  using Number = typename Shift::Number;
  using Index = Eigen::Index;

  void resize(Index) { lu_ = {}; }
  [[nodiscard]] Outcome factorize(auto& system, const auto& masses, const Shift& shift, Statistics& statistics) {
    const BandWidth most = system.band(masses);
    if (lu_.rows() != most.n || lu_.lower() > most.lower || lu_.upper() > most.upper) lu_.resize(most.n, 0, 0);
    if (lu_.lower() < most.lower || lu_.upper() < most.upper) widen(system, masses);
    lu_.clear();
    system.for_each_tangent([&](Index i, Index j, Scalar K, Scalar C) {
      if (is_inside(i, j)) lu_.column(j)[i - j] = shift.template of_tangents<facts>(K, C);
    });
    masses([&](Index i, Index j, auto m) { shift.add_mass(lu_.column(j)[i - j], static_cast<Scalar>(m)); });
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  void solve_in_place(Number* x) { lu_.solve_in_place(x); }
  void add_position_product(auto& system, Scalar factor, const auto& x, auto& out) const {
    add_padded_product(system, factor, x, out);
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

  LaneBandedLu<Scalar, lanes> lu_;
};

template <MatrixFacts facts, class Scalar, int lanes>
class LaneSystem<SystemKind::dense, facts, Scalar, lanes> : public DenseLaneSystem<facts, Scalar, lanes> {};
template <MatrixFacts facts, class Scalar, int lanes>
class LaneSystem<SystemKind::static_pattern, facts, Scalar, lanes> : public DenseLaneSystem<facts, Scalar, lanes> {};
template <MatrixFacts facts, class Scalar, int lanes>
class LaneSystem<SystemKind::diagonal, facts, Scalar, lanes>
    : public std::conditional_t<facts.n != Eigen::Dynamic && facts.n <= small_lanes,
                                DenseLaneSystem<facts, Scalar, lanes>, BandedLaneSystem<facts, Scalar, lanes>> {};
template <MatrixFacts facts, class Scalar, int lanes>
class LaneSystem<SystemKind::particles, facts, Scalar, lanes> : public BandedLaneSystem<facts, Scalar, lanes> {};
template <MatrixFacts facts, class Scalar, int lanes>
class LaneSystem<SystemKind::banded, facts, Scalar, lanes> : public BandedLaneSystem<facts, Scalar, lanes> {};

}}  // namespace phistep::PHISTEP_ABI
