/// @file
/// LU of sparse matrices without symmetry; of numbers, or of several complex ones side by side (linear/lanes/complex_pack.hpp).
///
/// Left-looking, column by column (J. R. Gilbert & T. Peierls, SIAM J. Sci. Stat. Comput. 9 (1988) 862), with pruned
/// columns (S. C. Eisenstat & J. W. H. Liu, SIAM J. Matrix Anal. Appl. 14 (1993) 253), in the order of approximate minimum degree
/// of W + Wᵀ; rows change places where a multiplier would be too large (complex_pack.hpp). What the first factorization found out,
/// the order of the pivots and the pattern of L and U, serves the next ones while their pivots can be trusted (T. A. Davis &
/// E. Palamadai Natarajan, ACM Trans. Math. Softw. 37 (2010) 36:1): these allocate nothing. Columns of L with one pattern are
/// subtracted up to four in a pass over it, real ones; several matrices side by side share the indices anyway.
#pragma once

#include <Eigen/Core>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "phistep/linear/banded/banded_lu.hpp"
#include "phistep/linear/lanes/complex_pack.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// analyzePattern(W), factorize(W), info() as Eigen's solvers have them; solve_in_place(x).
template <class Number>
class SparseLu {
 public:
  /// @param W  compressed, columns sorted, with a full diagonal
  void analyzePattern(const auto& W) {
    const std::size_t n = at(W.cols());
    column_.resize(n), row_.resize(n), place_.resize(n), seen_.resize(n), nested_.resize(n), end_.resize(n);
    inverse_pivot_.resize(n);
    x_.assign(n, Number{});
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, Place> order;
    Eigen::AMDOrdering<Place>{}(W, order);
    std::copy(order.indices().data(), order.indices().data() + n, column_.begin());
    is_planned_ = is_compared_ = false;
  }
  void factorize(const auto& W) { static_cast<void>(factorize(W, W.valuePtr())); }
  /// Factorizes the matrix of these values, by columns, as the pattern has them. False where a pivot is zero or not finite.
  [[nodiscard]] bool factorize(const auto& pattern, const Number* values) {
    if (std::exchange(is_planned_, false) && repeat(pattern, values)) return is_planned_ = true;
    is_planned_ = choose_pivots(pattern, values);
    // Where many rows change places, W + Wᵀ says little of the fill: WᵀW bounds it for all of their exchanges.
    if (is_planned_ && !is_compared_ && 4 * exchanges_ > x_.size()) {
      is_compared_ = true;
      SparseLu other = *this;
      Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, Place> places;
      Eigen::COLAMDOrdering<Place>{}(pattern, places);
      for (std::size_t j = 0; j < x_.size(); ++j) other.column_[at(places.indices().data()[j])] = static_cast<Place>(j);
      if (other.choose_pivots(pattern, values, fill())) *this = std::move(other);
    }
    return is_planned_;
  }
  [[nodiscard]] Eigen::ComputationInfo info() const { return is_planned_ ? Eigen::Success : Eigen::NumericalIssue; }
  /// x ← W⁻¹ x
  void solve_in_place(auto&& x) {
    for (std::size_t k = 0; k < x_.size(); ++k) x_[k] = x[row_[k]];
    for (std::size_t k = 0; k < x_.size();)
      k += subtract_some(k, x_.size(), [this](std::size_t c) -> const Number& { return x_[c]; });
    for (std::size_t k = x_.size(); k-- > 0;) {
      x_[k] = x_[k] * inverse_pivot_[k];
      U_.subtract(k, x_[k], x_);
    }
    for (std::size_t k = 0; k < x_.size(); ++k) x[column_[k]] = x_[k];
    std::fill(x_.begin(), x_.end(), Number{});
  }
  /// Entries of L and U, diagonals aside.
  [[nodiscard]] std::size_t fill() const { return L_.row.size() + U_.row.size(); }

 private:
  using Place = std::int32_t;
  static constexpr Place none = -1;
  [[nodiscard]] static std::size_t at(auto i) { return static_cast<std::size_t>(i); }
  /// A triangle without its diagonal, by columns.
  struct Triangle {
    std::vector<std::size_t> start;
    std::vector<Place> row;
    std::vector<Number> value;
    void clear() { start.assign(1, 0), row.clear(), value.clear(); }
    void push(Place i, const Number& x) { row.push_back(i), value.push_back(x); }
    /// to −= by · column k
    void subtract(std::size_t k, const Number by, std::vector<Number>& to) const {
      for (std::size_t p = start[k]; p < start[k + 1]; ++p)
        subtract_product(to[static_cast<std::size_t>(row[p])], value[p], by);
    }
  };

  void scatter(const auto& pattern, const Number* values, Place j, auto&& place) {
    for (auto p = pattern.outerIndexPtr()[j]; p < pattern.outerIndexPtr()[j + 1]; ++p)
      x_[at(place(pattern.innerIndexPtr()[p]))] = values[p];
  }

  /// x −= Σ x_c L_c for columns c of one pattern from k on, `most` at most; says how many. take(c) is x_c.
  [[gnu::always_inline]] std::size_t subtract_some(std::size_t k, std::size_t most, auto&& take) {
    if constexpr (std::floating_point<Number> || is_pack<Size<Number>>) {
      const std::size_t all = std::min(most, at(nested_[k]) + 1);
      if (all >= 4) return subtract_columns<4>(k, take);
      if (all >= 2) return subtract_columns<2>(k, take);
    }
    L_.subtract(k, take(k), x_);
    return 1;
  }
  template <std::size_t count>
  std::size_t subtract_columns(std::size_t k, auto&& take) {
    const Number* value[count];
    Number u[count];
    for (std::size_t c = 0; c < count; ++c) {
      u[c] = take(k + c);
      value[c] = L_.value.data() + L_.start[k + c];
      for (std::size_t d = c + 1; d < count; ++d) subtract_product(x_[k + d], *value[c]++, u[c]);
    }
    const std::size_t first = L_.start[k + count - 1], rows = L_.start[k + count] - first;
    const Place* const row = L_.row.data() + first;
    Number* const x = x_.data();
    for (std::size_t p = 0; p < rows; ++p) {
      Number& to = x[row[p]];
      Number sum = to;
      for (std::size_t c = 0; c < count; ++c) subtract_product(sum, value[c][p], u[c]);
      to = sum;
    }
    return count;
  }

  /// The same pivots again, in places already known: rows of L are numbered by them. False where one can't be trusted.
  [[nodiscard]] bool repeat(const auto& pattern, const Number* values) {
    for (std::size_t k = 0; k < x_.size(); ++k) {
      scatter(pattern, values, column_[k], [this](auto i) { return place_[at(i)]; });
      for (std::size_t p = U_.start[k]; p < U_.start[k + 1];) {
        // Columns with the pattern of i that follow it belong to U, too.
        const std::size_t i = at(U_.row[p]);
        Number* const above = U_.value.data() + p;
        p += subtract_some(i, k - i, [this, i, above](std::size_t c) -> const Number& {
          return above[c - i] = std::exchange(x_[c], Number{});
        });
      }
      const Number pivot = std::exchange(x_[k], Number{});
      Number inverse = pivot;
      const bool is_regular = invert(inverse);
      inverse_pivot_[k] = inverse;
      Size<Number> largest{0};
      for (std::size_t p = L_.start[k]; p < L_.start[k + 1]; ++p) {
        const Number below = std::exchange(x_[at(L_.row[p])], Number{});
        largest = larger(size_of(below), largest);
        L_.value[p] = below * inverse;
      }
      // Ten times looser than where they were chosen: a small change of Δt needn't cost a new plan.
      if (!is_regular || !is_trusted<10>(pivot, largest)) return false;
    }
    return true;
  }

  /// Pivots, patterns and factors. The diagonal's where it can be trusted: there is least fill with it.
  /// @param most  entries of L and U: false as soon as there are more
  [[nodiscard]] bool choose_pivots(const auto& pattern, const Number* values, std::size_t most = SIZE_MAX) {
    const std::size_t n = x_.size();
    L_.clear(), U_.clear();
    exchanges_ = 0;
    std::fill(x_.begin(), x_.end(), Number{});
    std::fill(place_.begin(), place_.end(), none);
    std::fill(seen_.begin(), seen_.end(), none);
    for (std::size_t k = 0; k < n; ++k) {
      const Place j = column_[k];
      candidates_.clear(), pending_.clear();
      // Rows of column k: candidates, and, the first pivot first, those of earlier pivots, whose columns of L reach more.
      const auto reach = [this, k](Place i) {
        if (std::exchange(seen_[at(i)], static_cast<Place>(k)) == static_cast<Place>(k)) return;
        if (place_[at(i)] == none) return candidates_.push_back(i);
        pending_.push_back(place_[at(i)]);
        std::push_heap(pending_.begin(), pending_.end(), std::greater{});
      };
      reach(j);
      for (auto p = pattern.outerIndexPtr()[j]; p < pattern.outerIndexPtr()[j + 1]; ++p)
        reach(pattern.innerIndexPtr()[p]);
      scatter(pattern, values, j, [](auto i) { return i; });
      while (!pending_.empty()) {
        std::pop_heap(pending_.begin(), pending_.end(), std::greater{});
        const std::size_t c = at(pending_.back());
        pending_.pop_back();
        for (std::size_t p = L_.start[c]; p < end_[c]; ++p) reach(L_.row[p]);
        U_.push(static_cast<Place>(c), std::exchange(x_[at(row_[c])], Number{}));
        L_.subtract(c, U_.value.back(), x_);
      }
      if (candidates_.empty() || fill() > most) return false;
      const auto candidate = [this](std::size_t c) -> Number& { return x_[at(candidates_[c])]; };
      const std::size_t chosen = threshold_pivot<Number>(candidates_.size(), candidate);
      if (!invert(inverse_pivot_[k] = candidate(chosen))) return false;
      std::swap(candidates_[0], candidates_[chosen]);
      row_[k] = candidates_[0];
      place_[at(row_[k])] = static_cast<Place>(k);
      exchanges_ += row_[k] != j ? 1 : 0;
      candidate(0) = Number{};
      for (std::size_t c = 1; c < candidates_.size(); ++c)
        L_.push(candidates_[c], std::exchange(candidate(c), Number{}) * inverse_pivot_[k]);
      L_.start.push_back(end_[k] = L_.row.size());
      U_.start.push_back(U_.row.size());
      prune(k);
    }
    for (Place& i : L_.row) i = place_[at(i)];
    for (std::size_t k = n; k-- > 0;) sort_column(k);
    return true;
  }
  /// A column of L with pivot k's row, and U's column k: what else it reaches is reached through L's column k from now on.
  void prune(std::size_t k) {
    for (std::size_t p = U_.start[k]; p < U_.start[k + 1]; ++p) {
      const std::size_t c = at(U_.row[p]);
      const Place *const first = L_.row.data() + L_.start[c], *const last = L_.row.data() + L_.start[c + 1];
      if (end_[c] != L_.start[c + 1] || std::find(first, last, row_[k]) == last) continue;
      for (std::size_t q = L_.start[c]; q < end_[c];)
        if (place_[at(L_.row[q])] != none) ++q;
        else std::swap(L_.row[q], L_.row[--end_[c]]), std::swap(L_.value[q], L_.value[end_[c]]);
    }
  }
  /// A column of L in the order of its rows, and how many with the same ones follow.
  void sort_column(std::size_t k) {
    Place* const row = L_.row.data() + L_.start[k];
    Number* const value = L_.value.data() + L_.start[k];
    sorted_.resize(L_.start[k + 1] - L_.start[k]);
    for (std::size_t p = 0; p < sorted_.size(); ++p) sorted_[p] = {row[p], value[p]};
    std::sort(sorted_.begin(), sorted_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t p = 0; p < sorted_.size(); ++p) row[p] = sorted_[p].first, value[p] = sorted_[p].second;
    Place* const last = row + sorted_.size();
    const bool is_nested =
        row != last && at(row[0]) == k + 1 && std::equal(row + 1, last, last, L_.row.data() + L_.start[k + 2]);
    nested_[k] = is_nested ? nested_[k + 1] + 1 : 0;
  }

  std::vector<Place> column_, row_, place_;  // of W: the column and the row of pivot k; the pivot of a row
  Triangle L_, U_;                           // L without its diagonal of ones; rows are numbered by their pivots
  std::vector<Place> nested_;                // columns of L after k with the rows of k's below them
  std::vector<Number> inverse_pivot_;
  std::vector<Number> x_;  // a column, zero between uses
  std::vector<Place> seen_, pending_, candidates_;
  std::vector<std::size_t> end_;  // of what a column of L has to reach by itself
  std::vector<std::pair<Place, Number>> sorted_;
  std::size_t exchanges_ = 0;  // pivots that aren't their column's diagonal
  bool is_planned_ = false, is_compared_ = false;
};

}}  // namespace phistep::PHISTEP_ABI
