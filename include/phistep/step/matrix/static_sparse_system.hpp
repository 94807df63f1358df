/// @file
/// The step's matrix W = M − γC of a first-order state of few unknowns whose force names the pattern of its Jacobian:
///
///     static constexpr auto jacobian_pattern = phistep::entries({{0, 0}, {0, 1}, {1, 0}});     // (row, column)
///
/// The elimination is planned at compile time, and written out entry by entry, without an index or a zero.
///
/// Pivots lie on the diagonal, in the order of least fill (H. M. Markowitz, Management Sci. 3 (1957) 255: the pivot with
/// the fewest (r−1)(c−1), r and c being the entries left in its row and column). W = M − γJ of stable equations seldom needs
/// others. Where a multiplier exceeds `largest_multiplier` all the same, the factorization is done again as a dense one with
/// row pivoting: slower, and no less accurate (threshold pivoting, I. S. Duff, A. M. Erisman & J. K. Reid, Direct Methods
/// for Sparse Matrices, sect. 5.2).
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
#include "phistep/step/matrix/choice.hpp"
#include "phistep/step/matrix/dense_system.hpp"
#include "phistep/step/matrix/small_dense_lu.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Where a matrix may be other than zero.
struct MatrixEntry {
  int row = 0, column = 0;
};

/// A list of entries, as a force's `static constexpr auto jacobian_pattern = entries({{0, 1}, {1, 0}, {1, 1}});`
template <std::size_t count>
[[nodiscard]] consteval std::array<MatrixEntry, count> entries(const MatrixEntry (&list)[count]) {
  return std::to_array(list);
}

/// The same list from the Jacobian itself, n×n: f(y, put) calls put(i, j, x) for every entry x of it, and can do so at
/// compile time, for y a std::array of ones.
///
///     static constexpr auto jacobian_pattern = pattern_of<3>([](const auto& y, auto&& put) { Law::entries(y, put); });
template <int n>
[[nodiscard]] consteval auto pattern_of(auto f) {
  struct {
    std::array<MatrixEntry, static_cast<std::size_t>(n* n)> all{};
    std::size_t count = 0;
    [[nodiscard]] constexpr auto begin() const { return all.begin(); }
    [[nodiscard]] constexpr auto end() const { return all.begin() + count; }
    [[nodiscard]] constexpr std::size_t size() const { return count; }
  } pattern;
  std::array<double, static_cast<std::size_t>(n)> ones{};
  ones.fill(1);
  std::array<bool, static_cast<std::size_t>(n * n)> seen{};
  f(std::as_const(ones), [&](int i, int j, auto) {
    if (!std::exchange(seen.at(static_cast<std::size_t>(i * n + j)), true)) pattern.all[pattern.count++] = {i, j};
  });
  return pattern;
}

/// The elimination of an n×n matrix with a full diagonal and the entries given.
template <int n>
struct EliminationPlan {
  static constexpr int none = -1;
  std::array<std::array<int, n>, n> slot{};  ///< of (row, column), fill included, the diagonal first; none elsewhere
  std::array<int, n> order{};                ///< of the pivots
  std::array<int, n> step{};                 ///< at which a row is the pivot's
  int slots = 0;                             ///< entries, fill included
  int products = 0;                          ///< multiplications of an elimination

  /// @throws where an entry lies outside: a compile-time error
  consteval explicit EliminationPlan(const auto& pattern) {
    std::array<std::array<bool, n>, n> filled{}, left{};
    for (int i = 0; i < n; ++i) filled[at(i)][at(i)] = true;
    for (const MatrixEntry& e : pattern) {
      if (e.row < 0 || e.row >= n || e.column < 0 || e.column >= n) throw "phistep: a pattern's entry lies outside";
      filled[at(e.row)][at(e.column)] = true;
    }
    left = filled;
    std::array<bool, n> done{};
    for (int k = 0; k < n; ++k) {
      int best = none, least = 0;
      for (int p = 0; p < n; ++p) {
        if (done[at(p)]) continue;
        int in_row = 0, in_column = 0;
        for (int i = 0; i < n; ++i) {
          in_row += left[at(p)][at(i)] ? 1 : 0;
          in_column += left[at(i)][at(p)] ? 1 : 0;
        }
        const int fill = (in_row - 1) * (in_column - 1);
        if (best == none || fill < least) best = p, least = fill;
      }
      order[at(k)] = best;
      step[at(best)] = k;
      done[at(best)] = true;
      products += least;
      for (int i = 0; i < n; ++i) {
        if (i == best || !left[at(i)][at(best)]) continue;
        for (int j = 0; j < n; ++j)
          if (j != best && left[at(best)][at(j)]) left[at(i)][at(j)] = filled[at(i)][at(j)] = true;
      }
      for (int i = 0; i < n; ++i) left[at(i)][at(best)] = left[at(best)][at(i)] = false;
    }
    slots = n;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) slot[at(i)][at(j)] = i == j ? i : filled[at(i)][at(j)] ? slots++ : none;
  }
  [[nodiscard]] static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] constexpr int operator()(int row, int column) const { return slot[at(row)][at(column)]; }
};

/// @tparam Force  names `jacobian_pattern`, what entries() or pattern_of() made
template <class Scalar, int n, class Force>
class StaticSparseLu {
 public:
  static constexpr EliminationPlan<n> plan{Force::jacobian_pattern};
  static constexpr int slots = plan.slots;
  /// Pivots smaller than 1/this of what is below them are not trusted.
  static constexpr Scalar largest_multiplier = 8;

  using Values = std::array<Scalar, static_cast<std::size_t>(slots)>;

  /// fill(values) sets the entries of all slots, the fill's to 0. It is called again where pivots have to be chosen.
  /// False where one is zero, not finite or too small to have a reciprocal.
  [[nodiscard]] bool factorize(auto&& fill) {
    fill(a_);
    Scalar multiplier{0};
    eliminate(multiplier, std::make_integer_sequence<int, n>{});
    is_dense_ = !(multiplier <= largest_multiplier && all_invertible(inverse_pivot_));
    if (!is_dense_) [[likely]]
      return true;
    fill(a_);
    return factorize_densely();
  }
  void solve_in_place(auto&& x) const {
    if (is_dense_) [[unlikely]]
      return dense_.solve_in_place(x);
    Scalar y[n];
    unrolled<n>([&](auto k) PHISTEP_DETAIL_INLINED { y[k] = x[k]; });
    unrolled<n>([&](auto k) PHISTEP_DETAIL_INLINED {
      unrolled<later<k>.rows>(
          [&](auto i) PHISTEP_DETAIL_INLINED { y[below<k>(i)] -= entry<below<k>(i), pivot<k>>() * y[pivot<k>]; });
    });
    unrolled<n>([&](auto k) PHISTEP_DETAIL_INLINED { y[k] *= inverse_pivot_[plan.step[static_cast<std::size_t>(k)]]; });
    unrolled<n>([&](auto done) PHISTEP_DETAIL_INLINED {
      constexpr int k = n - 1 - done;
      unrolled<later<k>.columns>(
          [&](auto j) PHISTEP_DETAIL_INLINED { y[pivot<k>] -= entry<pivot<k>, beside<k>(j)>() * y[beside<k>(j)]; });
    });
    unrolled<n>([&](auto k) PHISTEP_DETAIL_INLINED { x[int{k}] = y[k]; });
  }
  /// Whether the last factorization had to choose its pivots.
  [[nodiscard]] bool is_dense() const { return is_dense_; }

 private:
  template <int k>
  static constexpr int pivot = plan.order[static_cast<std::size_t>(k)];
  /// Entries of pivot k's row (or column) that are left when it is eliminated, and which they are.
  template <int k>
  static constexpr auto later = [] {
    struct {
      std::array<int, n> row{}, column{};
      int rows = 0, columns = 0;
    } all;
    for (int i = 0; i < n; ++i) {
      if (plan.step[static_cast<std::size_t>(i)] <= k) continue;
      if (plan(i, pivot<k>) >= 0) all.row[static_cast<std::size_t>(all.rows++)] = i;
      if (plan(pivot<k>, i) >= 0) all.column[static_cast<std::size_t>(all.columns++)] = i;
    }
    return all;
  }();
  template <int k>
  static constexpr int below(int i) {
    return later<k>.row[static_cast<std::size_t>(i)];
  }
  template <int k>
  static constexpr int beside(int j) {
    return later<k>.column[static_cast<std::size_t>(j)];
  }
  template <int row, int column>
  [[nodiscard]] [[gnu::always_inline]] Scalar& entry() {
    static_assert(plan(row, column) >= 0);
    return a_[static_cast<std::size_t>(plan(row, column))];
  }
  template <int row, int column>
  [[nodiscard]] [[gnu::always_inline]] Scalar entry() const {
    static_assert(plan(row, column) >= 0);
    return a_[static_cast<std::size_t>(plan(row, column))];
  }

  template <int... k>
  [[gnu::always_inline]] void eliminate(Scalar& multiplier, std::integer_sequence<int, k...>) {
    (eliminate_one<k>(multiplier, std::make_integer_sequence<int, later<k>.rows>{},
                      std::make_integer_sequence<int, later<k>.columns>{},
                      std::make_integer_sequence<int, later<k>.rows * later<k>.columns>{}),
     ...);
  }
  // U's rows are divided by their pivots, after use, so that a solve multiplies by them while it waits for others.
  template <int k, int... i, int... j, int... product>
  [[gnu::always_inline]] void eliminate_one(Scalar& multiplier, std::integer_sequence<int, i...>,
                                            std::integer_sequence<int, j...>, std::integer_sequence<int, product...>) {
    using std::abs;
    constexpr int p = pivot<k>, columns = std::max(1, later<k>.columns);
    [[maybe_unused]] const Scalar inverse = inverse_pivot_[k] = Scalar{1} / entry<p, p>();
    ((entry<below<k>(i), p>() *= inverse, multiplier = larger(multiplier, abs(entry<below<k>(i), p>()))), ...);
    ((entry<below<k>(product / columns), beside<k>(product % columns)>() -=
      entry<below<k>(product / columns), p>() * entry<p, beside<k>(product % columns)>()),
     ...);
    ((entry<p, beside<k>(j)>() *= inverse), ...);
  }
  /// NaN, once there, stays.
  [[nodiscard]] static Scalar larger(Scalar a, Scalar b) { return b <= a ? a : b; }

  // Out of line: it is not to be weighed against the elimination.
  [[gnu::cold, gnu::noinline]] bool factorize_densely() {
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        dense_.matrix()(i, j) = plan(i, j) < 0 ? Scalar{0} : a_[static_cast<std::size_t>(plan(i, j))];
    return dense_.factorize();
  }

  Values a_{};
  Scalar inverse_pivot_[n]{};
  bool is_dense_ = false;
  DenseLu<Scalar, n> dense_;
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
template <class Scalar, int n, class Force, bool constant>
class StaticSparseSystem : public SystemDefaults {
  using Lu = StaticSparseLu<Scalar, n, Force>;

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
  using type = StaticSparseSystem<Scalar, facts.n, Force, facts.constant>;
};

}}  // namespace phistep::PHISTEP_ABI
