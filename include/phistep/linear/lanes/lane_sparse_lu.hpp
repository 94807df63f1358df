/// @file
/// LU of several complex sparse matrices of one pattern side by side, one a lane: W_l, l = 0 … lanes − 1.
///
/// Left-looking, column by column (J. R. Gilbert & T. Peierls, SIAM J. Sci. Stat. Comput. 9 (1988) 862), in the order of
/// approximate minimum degree of W + Wᵀ; rows change places where a multiplier would be too large (complex_pack.hpp). What the
/// first factorization found out, the order of the pivots and the pattern of L and U, serves the next ones while their
/// pivots can be trusted (T. A. Davis & E. Palamadai Natarajan, ACM Trans. Math. Softw. 37 (2010) 36:1): these allocate
/// nothing. An index is read once for all lanes, which is what dense blocks of columns are for elsewhere.
#pragma once

#include <Eigen/Core>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/version.hpp"
#include "phistep/linear/lanes/complex_pack.hpp"
#include "phistep/linear/lanes/lane_system.hpp"
#include "phistep/step/matrix/choice.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// analyze(pattern), fill values(), factorize(), solve_in_place(x).
template <class Scalar, int lanes>
class LaneSparseLu {
 public:
  using Number = ComplexPack<Scalar, lanes>;
  using Real = typename Number::Real;

  /// @param pattern  compressed, columns sorted, with a full diagonal
  template <class Matrix>
  void analyze(const Matrix& pattern) {
    n_ = static_cast<int>(pattern.cols());
    const auto n = static_cast<std::size_t>(n_);
    outer_.assign(pattern.outerIndexPtr(), pattern.outerIndexPtr() + n + 1);
    inner_.assign(pattern.innerIndexPtr(), pattern.innerIndexPtr() + pattern.nonZeros());
    values_.resize(inner_.size());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, typename Matrix::StorageIndex> order;
    Eigen::AMDOrdering<typename Matrix::StorageIndex>{}(pattern, order);
    column_.assign(order.indices().data(), order.indices().data() + n);
    row_.resize(n), place_.resize(n), visited_.resize(n), stack_.resize(n), child_.resize(n), reach_.resize(n);
    x_.assign(n, Number{});
    inverse_pivot_.resize(n);
    is_planned_ = false;
  }
  /// The entries by columns, as the pattern has them.
  [[nodiscard]] std::vector<Number>& values() { return values_; }

  /// False where a pivot is zero or not finite.
  [[nodiscard]] bool factorize() {
    if (is_planned_ && repeat()) return true;
    is_planned_ = false;
    return is_planned_ = choose_pivots();
  }
  /// x ← W⁻¹ x
  void solve_in_place(auto&& x) {
    for (std::size_t k = 0; k < x_.size(); ++k) x_[k] = x[row_[k]];
    for (std::size_t k = 0; k < x_.size(); ++k) L_.subtract(k, x_[k], x_);
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
  /// A triangle without its diagonal, by columns.
  struct Triangle {
    std::vector<std::size_t> start;
    std::vector<Place> row;
    std::vector<Number> value;
    void clear() {
      start.assign(1, 0);
      row.clear(), value.clear();
    }
    void push(Place i, const Number& x) {
      row.push_back(i);
      value.push_back(x);
    }
    /// to −= by · column k
    void subtract(std::size_t k, const Number by, std::vector<Number>& to) const {
      for (std::size_t p = start[k]; p < start[k + 1]; ++p)
        subtract_product(to[static_cast<std::size_t>(row[p])], value[p], by);
    }
  };

  /// The same pivots again, in places already known: rows of L are numbered by them. False where one can't be trusted.
  [[nodiscard]] bool repeat() {
    for (std::size_t k = 0; k < x_.size(); ++k) {
      const auto j = static_cast<std::size_t>(column_[k]);
      for (auto p = static_cast<std::size_t>(outer_[j]); p < static_cast<std::size_t>(outer_[j + 1]); ++p)
        x_[static_cast<std::size_t>(place_[static_cast<std::size_t>(inner_[p])])] = values_[p];
      for (std::size_t p = U_.start[k]; p < U_.start[k + 1]; ++p) {
        const auto i = static_cast<std::size_t>(U_.row[p]);
        const Number u = U_.value[p] = std::exchange(x_[i], Number{});
        L_.subtract(i, u, x_);
      }
      const Number pivot = std::exchange(x_[k], Number{});
      Number inverse = pivot;
      const bool is_regular = invert(inverse);
      inverse_pivot_[k] = inverse;
      Real largest{Scalar{0}};
      for (std::size_t p = L_.start[k]; p < L_.start[k + 1]; ++p) {
        const Number below = std::exchange(x_[static_cast<std::size_t>(L_.row[p])], Number{});
        largest = larger(below.norm(), largest);
        L_.value[p] = below * inverse;
      }
      // Ten times looser than where they were chosen: a small change of Δt needn't cost a new plan.
      if (!is_regular || !all_at_least(pivot.norm() * Real{Scalar{100} * trusted}, largest)) {
        std::fill(x_.begin(), x_.end(), Number{});
        return false;
      }
    }
    return true;
  }

  /// Pivots, patterns and factors. The diagonal's where it can be trusted: there is least fill with it.
  [[nodiscard]] bool choose_pivots() {
    const auto n = x_.size();
    L_.clear(), U_.clear();
    std::fill(place_.begin(), place_.end(), none);
    std::fill(visited_.begin(), visited_.end(), none);
    for (std::size_t k = 0; k < n; ++k) {
      const auto j = static_cast<std::size_t>(column_[k]);
      std::size_t top = n;  // reach_[top …] are the rows of column k: those after which others come, first
      for (auto p = outer_[j]; p < outer_[j + 1]; ++p) {
        const auto i = inner_[static_cast<std::size_t>(p)];
        if (visited_[static_cast<std::size_t>(i)] != static_cast<Place>(k)) top = search(i, static_cast<Place>(k), top);
      }
      for (auto p = static_cast<std::size_t>(outer_[j]); p < static_cast<std::size_t>(outer_[j + 1]); ++p)
        x_[static_cast<std::size_t>(inner_[p])] = values_[p];
      candidates_.clear();
      if (place_[j] == none) candidates_.push_back(static_cast<Place>(j));
      const std::size_t first = U_.row.size();
      for (std::size_t at = top; at < n; ++at) {
        const Place i = reach_[at], place = place_[static_cast<std::size_t>(i)];
        if (place == none) {
          if (static_cast<std::size_t>(i) != j) candidates_.push_back(i);
          continue;
        }
        const Number u = std::exchange(x_[static_cast<std::size_t>(i)], Number{});
        L_.subtract(static_cast<std::size_t>(place), u, x_);
        U_.push(place, u);
      }
      sort_column(first);
      const std::size_t chosen =
          candidates_.empty() ? 0 : lane_pivot<Number>(candidates_.size(), [this](std::size_t c) { return at(c); });
      if (candidates_.empty() || !invert(inverse_pivot_[k] = at(chosen))) {
        std::fill(x_.begin(), x_.end(), Number{});
        return false;
      }
      std::swap(candidates_[0], candidates_[chosen]);
      place_[static_cast<std::size_t>(candidates_[0])] = static_cast<Place>(k);
      row_[k] = candidates_[0];
      for (std::size_t c = 1; c < candidates_.size(); ++c) L_.push(candidates_[c], at(c) * inverse_pivot_[k]);
      for (const Place i : candidates_) x_[static_cast<std::size_t>(i)] = Number{};
      L_.start.push_back(L_.row.size());
      U_.start.push_back(U_.row.size());
    }
    for (Place& i : L_.row) i = place_[static_cast<std::size_t>(i)];
    return true;
  }
  [[nodiscard]] const Number& at(std::size_t candidate) const {
    return x_[static_cast<std::size_t>(candidates_[candidate])];
  }
  /// Rows that are reached from i through columns of L, in front of those found before: depth first.
  [[nodiscard]] std::size_t search(Place i, Place k, std::size_t top) {
    std::size_t depth = 0;
    const auto enter = [&](Place row) {
      visited_[static_cast<std::size_t>(row)] = k;
      const Place place = place_[static_cast<std::size_t>(row)];
      stack_[depth] = row;
      child_[depth++] = place == none ? 0 : L_.start[static_cast<std::size_t>(place)];
    };
    enter(i);
    while (depth > 0) {
      const Place row = stack_[depth - 1], place = place_[static_cast<std::size_t>(row)];
      const std::size_t end = place == none ? 0 : L_.start[static_cast<std::size_t>(place) + 1];
      std::size_t& next = child_[depth - 1];
      while (next < end && visited_[static_cast<std::size_t>(L_.row[next])] == k) ++next;
      if (next < end) {
        enter(L_.row[next++]);
      } else {
        --depth;
        reach_[--top] = row;
      }
    }
    return top;
  }
  /// U's column in the order of its rows, in which repeat() can go through it.
  void sort_column(std::size_t first) {
    order_.resize(U_.row.size() - first);
    for (std::size_t p = 0; p < order_.size(); ++p) order_[p] = {U_.row[first + p], U_.value[first + p]};
    std::sort(order_.begin(), order_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t p = 0; p < order_.size(); ++p)
      U_.row[first + p] = order_[p].first, U_.value[first + p] = order_[p].second;
  }

  static constexpr Scalar trusted = static_cast<Scalar>(largest_lane_multiplier * largest_lane_multiplier);
  int n_ = 0;
  std::vector<Place> outer_, inner_;  // the pattern
  std::vector<Number> values_;
  std::vector<Place> column_, row_, place_;  // of W: the column and the row of pivot k; the pivot of a row
  Triangle L_, U_;                           // rows are pivots
  std::vector<Number> inverse_pivot_, x_;    // x_: zeros between uses
  std::vector<Place> visited_, stack_, reach_, candidates_;
  std::vector<std::size_t> child_;
  std::vector<std::pair<Place, Number>> order_;
  bool is_planned_ = false;
};

// Factors of several shifted sparse matrices with the same tangents, one a lane (lane_system.hpp).

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

/// LU over a sparse assembly: an analysis for each pattern, none for new values.
template <MatrixFacts facts, class Scalar, int lanes>
class SparseLaneSystem {
 public:
  using Shift = LaneShift<Scalar, lanes>;
  using Number = typename Shift::Number;

  void resize(Eigen::Index) { is_analyzed_ = false; }
  void forget_pattern() { is_analyzed_ = false; }
  [[nodiscard]] Outcome factorize(auto& system, const auto& masses, const Shift& shift, Statistics& statistics) {
    if (system.settle(masses) || !is_analyzed_) {
      is_analyzed_ = false;
      lu_.analyze(system.pattern());
      ++statistics.analyses;
      is_analyzed_ = true;
    }
    auto& W = lu_.values();
    system.for_each_tangent(
        [&](std::size_t slot, Scalar K, Scalar C) { W[slot] = shift.template of_tangents<facts>(K, C); });
    system.for_each_mass(masses, [&](std::size_t slot, Scalar m) { shift.add_mass(W[slot], m); });
    ++statistics.factorizations;
    return lu_.factorize() ? Outcome::success : Outcome::singular_matrix;
  }
  void solve_in_place(Number* x) { lu_.solve_in_place(x); }
  void add_position_product(auto& system, Scalar factor, const auto& x, auto& out) const {
    Eigen::Map<Eigen::Matrix<Scalar, Eigen::Dynamic, 1>> to(out.data(), static_cast<Eigen::Index>(out.size()));
    system.add_position_product(factor, ZerosBeyond{x}, to);
  }

 private:
  LaneSparseLu<Scalar, lanes> lu_;
  bool is_analyzed_ = false;
};

template <MatrixFacts facts, class Scalar, int lanes>
class LaneSystem<SystemKind::sparse, facts, Scalar, lanes> : public SparseLaneSystem<facts, Scalar, lanes> {};
template <MatrixFacts facts, class Scalar, int lanes>
class LaneSystem<SystemKind::symmetric_sparse, facts, Scalar, lanes> : public SparseLaneSystem<facts, Scalar, lanes> {};

}}  // namespace phistep::PHISTEP_ABI
