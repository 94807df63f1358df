/// @file
/// Groups of columns that one force call can difference together: no two columns of a group share a row.
///
/// Moving all of a group's components at once changes each row by the part of one column alone, so a Jacobian costs a
/// call a group instead of a call a column (Curtis, Powell & Reid, J. Inst. Math. Appl. 13 (1974) 117). The fewest groups
/// are a colouring of the columns' intersection graph; greedy colouring takes each column in turn and gives it the first
/// colour that no neighbour has, which is optimal for a band in natural order and good elsewhere with the columns of most
/// neighbours first (Coleman & Moré, SIAM J. Numer. Anal. 20 (1983) 187).
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "phistep/base/version.hpp"
#include "phistep/force/annotate.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The columns of an n×n pattern, by colour. A template, so that programs without patterns don't compile it.
template <class Pattern = ColumnPattern>
class ColumnColoring {
 public:
  ColumnColoring() = default;
  /// @throws std::invalid_argument where the pattern isn't one of an n×n matrix
  ColumnColoring(const Pattern& pattern, Eigen::Index n) {
    check(pattern, n);
    const Rows rows = columns_of_rows(pattern);
    const auto size = static_cast<std::size_t>(n);
    std::vector<std::size_t> order(size);
    std::iota(order.begin(), order.end(), std::size_t{0});
    const Colors natural = greedy(pattern, rows, order);
    std::vector<Eigen::Index> neighbors(size, 0);  // an upper bound: a neighbour by two rows counts twice
    for (std::size_t j = 0; j < size; ++j)
      for (auto p = pattern.start[j]; p < pattern.start[j + 1]; ++p) {
        const auto i = at(pattern.row, p);
        neighbors[j] += rows.start[i + 1] - rows.start[i];
      }
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return neighbors[a] > neighbors[b]; });
    const Colors largest_first = greedy(pattern, rows, order);
    group(largest_first.count < natural.count ? largest_first : natural);
  }

  [[nodiscard]] Eigen::Index colors() const { return static_cast<Eigen::Index>(start_.size()) - 1; }
  /// The columns of one colour, ascending.
  [[nodiscard]] auto columns(Eigen::Index color) const {
    struct Range {
      const Eigen::Index *first, *last;
      [[nodiscard]] const Eigen::Index* begin() const { return first; }
      [[nodiscard]] const Eigen::Index* end() const { return last; }
    };
    const auto c = static_cast<std::size_t>(color);
    return Range{column_.data() + start_[c], column_.data() + start_[c + 1]};
  }

 private:
  struct Rows {
    std::vector<Eigen::Index> start, column;
  };
  struct Colors {
    std::vector<std::size_t> of;
    std::size_t count = 0;
  };
  [[nodiscard]] static std::size_t at(const std::vector<Eigen::Index>& list, Eigen::Index p) {
    return static_cast<std::size_t>(list[static_cast<std::size_t>(p)]);
  }

  static void check(const Pattern& pattern, Eigen::Index n) {
    bool valid = pattern.columns() == n && pattern.start.front() == 0 &&
                 std::is_sorted(pattern.start.begin(), pattern.start.end()) &&
                 pattern.start.back() == static_cast<Eigen::Index>(pattern.row.size());
    for (std::size_t j = 0; valid && j + 1 < pattern.start.size(); ++j)
      for (auto p = pattern.start[j]; p < pattern.start[j + 1]; ++p) {
        const auto* const row = pattern.row.data() + p;
        valid = valid && *row >= 0 && *row < n && (p == pattern.start[j] || row[-1] < row[0]);
      }
    if (!valid) throw std::invalid_argument("phistep: the force's sparsity pattern doesn't fit its unknowns");
  }
  [[nodiscard]] static Rows columns_of_rows(const Pattern& pattern) {
    const std::size_t n = pattern.start.size() - 1;
    Rows rows{std::vector<Eigen::Index>(n + 1, 0), std::vector<Eigen::Index>(pattern.row.size())};
    for (const Eigen::Index i : pattern.row) ++rows.start[static_cast<std::size_t>(i) + 1];
    std::partial_sum(rows.start.begin(), rows.start.end(), rows.start.begin());
    std::vector<Eigen::Index> next(rows.start.begin(), rows.start.end() - 1);
    for (std::size_t j = 0; j < n; ++j)
      for (auto p = pattern.start[j]; p < pattern.start[j + 1]; ++p)
        rows.column[static_cast<std::size_t>(next[at(pattern.row, p)]++)] = static_cast<Eigen::Index>(j);
    return rows;
  }
  [[nodiscard]] static Colors greedy(const Pattern& pattern, const Rows& rows, const std::vector<std::size_t>& order) {
    const std::size_t none = order.size();
    Colors colors{std::vector<std::size_t>(order.size(), none)};
    std::vector<std::size_t> taken(order.size(), none);  // by colour: the last column that may not have it
    for (const std::size_t j : order) {
      for (auto p = pattern.start[j]; p < pattern.start[j + 1]; ++p) {
        const std::size_t i = at(pattern.row, p);
        for (auto q = rows.start[i]; q < rows.start[i + 1]; ++q)
          if (const std::size_t c = colors.of[at(rows.column, q)]; c != none) taken[c] = j;
      }
      std::size_t c = 0;
      while (taken[c] == j) ++c;
      colors.of[j] = c;
      colors.count = std::max(colors.count, c + 1);
    }
    return colors;
  }
  void group(const Colors& colors) {
    start_.assign(colors.count + 1, 0);
    for (const std::size_t c : colors.of) ++start_[c + 1];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    std::vector<Eigen::Index> next(start_.begin(), start_.end() - 1);
    column_.resize(colors.of.size());
    for (std::size_t j = 0; j < colors.of.size(); ++j)
      column_[static_cast<std::size_t>(next[colors.of[j]]++)] = static_cast<Eigen::Index>(j);
  }

  std::vector<Eigen::Index> start_{0}, column_;
};

}}  // namespace phistep::PHISTEP_ABI
