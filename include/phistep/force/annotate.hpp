/// @file
/// What a lambda can't say about itself. Each annotation wraps a force and is one; they nest:
///
///     affine(symmetric(sparsity(f, pattern)))
///
/// A force written as a struct says the same by members: `static constexpr bool is_affine = true;` and so on.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <functional>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class F>
inline constexpr bool is_called_only = true;
template <class F>
inline constexpr bool is_called_only<std::reference_wrapper<F>> =
    !has_member_named<F, NameAdd> && !has_member_named<F, NameJacobian>;

/// A function as an object that can be inherited from.
template <class F>
struct Callable : F {
  static_assert(
      is_called_only<F>,
      "phistep: an annotation of a std::ref would hide the force's members add and jacobian: annotate the force "
      "itself, and take std::ref of that");
  explicit constexpr Callable(F f) : F(std::move(f)) {}
};
template <class F>
  requires(!std::is_class_v<F> || std::is_final_v<F>)
struct Callable<F> {
  F function;
  explicit constexpr Callable(F f) : function(std::move(f)) {}
  template <class... Arguments>
    requires std::is_invocable_v<const F&, Arguments...>
  constexpr decltype(auto) operator()(Arguments&&... arguments) const {
    return function(std::forward<Arguments>(arguments)...);
  }
};

/// Annotates a force, the force in a term, or every term of a sum, by what the annotation says of it.
template <template <class> class Annotation, class F>
[[nodiscard]] constexpr auto annotate(F f, const auto&... what) {
  if constexpr (is_sum<F>)
    return map_terms(std::move(f), [&](auto term) { return annotate<Annotation>(std::move(term), what...); });
  else if constexpr (std::is_base_of_v<WrappedForce, F>)
    return f.around(annotate<Annotation>(std::move(f.force), what...));
  else return Annotation<F>{std::move(f), what...};
}

/// Ψ is an affine function of (r, v), or of y: Ψ = f(t) + K r + C v with K and C constant in time. Checked in some of
/// the solves with one matrix (`is_looked_at`): a force that stops being affine is reported at the next check.
template <class F>
struct Affine : Callable<F> {
  static constexpr bool is_affine = true;
  using Callable<F>::Callable;
};
/// Promises that f is affine in the state, with coefficients that never change: the step's matrix is then factorized once
/// while Δt stays, and every step is one linear solve. A promise that isn't kept gives wrong answers; check_jacobian at two
/// states finds it.
template <class F>
[[nodiscard]] constexpr auto affine(F f) {
  return annotate<Affine>(std::move(f));
}

/// ∂Ψ/∂r and ∂Ψ/∂v (or ∂Ψ/∂y) are symmetric matrices.
template <class F>
struct Symmetric : Callable<F> {
  static constexpr bool is_symmetric = true;
  using Callable<F>::Callable;
};
/// Promises symmetric tangents (forces with a potential have them; sliding friction has not). A tangent that isn't is
/// reported as Outcome::not_symmetric.
template <class F>
[[nodiscard]] constexpr auto symmetric(F f) {
  return annotate<Symmetric>(std::move(f));
}

/// A force and its potential.
template <class F, class V>
struct WithEnergy : Callable<F> {
  V potential;
  constexpr WithEnergy(F f, V v) : Callable<F>(std::move(f)), potential(std::move(v)) {}

  template <class View>
    requires MotionLike<View>
  [[nodiscard]] auto energy(auto t, const View& y) const {
    if constexpr (std::is_invocable_v<const V&, decltype(y.r), decltype(t)>) {
      return potential(y.r, t);
    } else {
      static_assert(call_arity<F, View>() < 3,
                    "phistep: with_energy(f, V) needs V(r, t) for a force f(r, v, t); a driving force is better a term "
                    "of its own");
      return potential(y.r);
    }
  }
};

/// Gives a force its potential energy V(r), or V(r, t) [energy]: −∂V/∂r must be the force at v = 0. For a lambda, a term or
/// what `local<dim>(…)` takes:
///
///     auto pendulum = with_energy([](const Vec& r) -> Vec { return -9.81 * r.array().sin(); },
///                                 [](const Vec& r) { return -9.81 * r.array().cos().sum(); });
template <class F, class V>
[[nodiscard]] constexpr auto with_energy(F force, V potential) {
  if constexpr (is_a<Term, F>) return term(with_energy(std::move(force.force), std::move(potential)));
  else return WithEnergy<F, V>{std::move(force), std::move(potential)};
}

/// Which rows each column of a tangent has: for column j, row[start[j]] … row[start[j+1] − 1], ascending.
struct ColumnPattern {
  std::vector<Eigen::Index> start{0}, row;
  [[nodiscard]] Eigen::Index columns() const { return static_cast<Eigen::Index>(start.size()) - 1; }
  [[nodiscard]] std::span<const Eigen::Index> rows(Eigen::Index j) const {
    const auto* const first = start.data() + j;
    return {row.data() + first[0], row.data() + first[1]};
  }
  /// @throws std::invalid_argument where this isn't the pattern of an n×n matrix
  void check(Eigen::Index n) const {
    bool valid = columns() == n && start.front() == 0 && std::is_sorted(start.begin(), start.end()) &&
                 start.back() == std::ssize(row);
    for (Eigen::Index j = 0; valid && j < n; ++j)
      for (Eigen::Index last = -1; const Eigen::Index i : rows(j)) valid = valid && last < i && i < n, last = i;
    if (!valid) throw std::invalid_argument("phistep: the force's sparsity pattern doesn't fit its unknowns");
  }
};

/// Entries from `lower` below to `upper` above the diagonal of an n×n matrix, both in blocks of b × b.
[[nodiscard]] inline ColumnPattern band_pattern(Eigen::Index n, Eigen::Index lower, Eigen::Index upper,
                                                Eigen::Index b = 1) {
  ColumnPattern pattern;
  for (Eigen::Index j = 0; j < n; ++j) {
    const Eigen::Index first = std::max<Eigen::Index>(0, j / b - upper) * b;
    for (Eigen::Index i = first; i < std::min(n, (j / b + lower + 1) * b); ++i) pattern.row.push_back(i);
    pattern.start.push_back(static_cast<Eigen::Index>(pattern.row.size()));
  }
  return pattern;
}

/// The pattern of a force's tangents: of a sum, all that its terms' have; a term without one has a diagonal tangent.
[[nodiscard]] decltype(auto) pattern_of_tangents(auto& force, Eigen::Index n) {
  if constexpr (requires { force.pattern(n); }) {
    return force.pattern(n);
  } else {
    ColumnPattern all = band_pattern(n, 0, 0);
    if constexpr (is_sum<std::remove_cvref_t<decltype(force)>>)
      for_each_summand(force, [&](auto& term) {
        const ColumnPattern& its = pattern_of_tangents(term, n);
        its.check(n);
        ColumnPattern both;
        for (Eigen::Index j = 0; j < n; ++j) {
          std::ranges::set_union(all.rows(j), its.rows(j), std::back_inserter(both.row));
          both.start.push_back(std::ssize(both.row));
        }
        all = std::move(both);
      });
    return all;
  }
}

/// Of a sparse Eigen matrix: its stored entries, whatever their values.
template <class SparseMatrix>
[[nodiscard]] ColumnPattern pattern_of(const SparseMatrix& matrix) {
  std::vector<std::vector<Eigen::Index>> rows(static_cast<std::size_t>(matrix.cols()));
  for (Eigen::Index outer = 0; outer < matrix.outerSize(); ++outer)
    for (typename SparseMatrix::InnerIterator entry(matrix, outer); entry; ++entry)
      rows[static_cast<std::size_t>(entry.col())].push_back(entry.row());
  ColumnPattern pattern;
  for (auto& column : rows) {
    std::sort(column.begin(), column.end());
    pattern.row.insert(pattern.row.end(), column.begin(), column.end());
    pattern.start.push_back(static_cast<Eigen::Index>(pattern.row.size()));
  }
  return pattern;
}

/// A force whose tangents have entries only where a pattern says so; differences then need few force calls.
template <class F>
struct Patterned : Callable<F> {
  static constexpr Structure structure = Structure::sparse;
  ColumnPattern columns;
  Patterned(F f, ColumnPattern pattern) : Callable<F>(std::move(f)), columns(std::move(pattern)) {}
  [[nodiscard]] const ColumnPattern& pattern(Eigen::Index n) const {
    if (columns.columns() != n)
      throw std::invalid_argument("phistep: the sparsity pattern has " + std::to_string(columns.columns()) +
                                  " columns, there are " + std::to_string(n) + " unknowns");
    return columns;
  }
};
/// Declares where ∂Ψ/∂y (∂Ψ/∂r and ∂Ψ/∂v alike) may be non-zero, by a sparse matrix with entries there. Needs
/// <phistep/sparse.hpp>.
template <class F, class SparseMatrix>
[[nodiscard]] auto sparsity(F f, const SparseMatrix& matrix) {
  return annotate<Patterned>(std::move(f), pattern_of(matrix));
}

/// A force whose tangents are banded.
template <class F>
struct Banded : Callable<F> {
  static constexpr Structure structure = Structure::banded;
  Eigen::Index lower, upper;
  Banded(F f, Eigen::Index below, Eigen::Index above) : Callable<F>(std::move(f)), lower(below), upper(above) {
    if (below < 0 || above < 0) throw std::invalid_argument("phistep: a bandwidth must not be negative");
  }
  [[nodiscard]] ColumnPattern pattern(Eigen::Index n) const { return band_pattern(n, lower, upper); }
};
/// Declares that component i depends on components i − lower … i + upper only. A chain of groups of b components, each
/// depending on itself and its two neighbours, has lower = upper = 2b − 1.
/// @throws std::invalid_argument where a bandwidth is negative
template <class F>
[[nodiscard]] auto banded(F f, Eigen::Index lower, Eigen::Index upper) {
  return annotate<Banded>(std::move(f), lower, upper);
}

}}  // namespace phistep::PHISTEP_ABI
