#include <phistep/step/jacobian/difference_tangent.hpp>

#include <cstdlib>
#include <set>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Index = Eigen::Index;

namespace {

/// Every column once, ascending within its colour, and no two columns of a colour in one row.
void check_valid(const ColumnColoring<>& coloring, const ColumnPattern& pattern) {
  std::set<Index> seen;
  for (Index c = 0; c < coloring.colors(); ++c) {
    std::set<Index> rows;
    Index last = -1;
    for (const Index j : coloring.columns(c)) {
      CHECK(j > last);
      last = j;
      CHECK(seen.insert(j).second);
      const auto column = static_cast<std::size_t>(j);
      for (Index p = pattern.start[column]; p < pattern.start[column + 1]; ++p)
        CHECK(rows.insert(pattern.row[static_cast<std::size_t>(p)]).second);
    }
    CHECK(last >= 0);  // no colour without columns
  }
  CHECK(static_cast<Index>(seen.size()) == pattern.columns());
}
ColumnPattern pattern_of_columns(const std::vector<std::vector<Index>>& columns) {
  ColumnPattern pattern;
  for (const auto& rows : columns) {
    pattern.row.insert(pattern.row.end(), rows.begin(), rows.end());
    pattern.start.push_back(static_cast<Index>(pattern.row.size()));
  }
  return pattern;
}

}  // namespace

TEST_CASE("a band takes as many colours as it has diagonals, whatever its length") {
  for (const Index n : {7, 100, 3000})
    for (const Index lower : {0, 1, 2})
      for (const Index upper : {0, 1, 3}) {
        const ColumnPattern band = band_pattern(n, lower, upper);
        const ColumnColoring coloring(band, n);
        CAPTURE(n, lower, upper);
        CHECK(coloring.colors() == lower + upper + 1);
        if (n <= 100) check_valid(coloring, band);
      }
}

TEST_CASE("an arrow takes as many colours as its full row has entries") {
  // Row 0 sees every column: nothing to be saved. Column 0 alone, its transpose: two colours.
  std::vector<std::vector<Index>> full_row{{0}}, full_column{{0}};
  for (Index j = 1; j < 20; ++j) {
    full_row.push_back({0, j});
    full_column.push_back({j});
    full_column[0].push_back(j);
  }
  const ColumnPattern row = pattern_of_columns(full_row), column = pattern_of_columns(full_column);
  const ColumnColoring row_coloring(row, 20), column_coloring(column, 20);
  check_valid(row_coloring, row);
  check_valid(column_coloring, column);
  CHECK(row_coloring.colors() == 20);
  CHECK(column_coloring.colors() == 2);
}

TEST_CASE("columns of most neighbours go first where that saves colours") {
  // Columns on a path a-b-c-d (an edge is a shared row), numbered so that natural order meets both ends first and gives
  // them one colour: then b and c need two more. Largest first takes b and c first: two colours in all.
  const ColumnPattern path = pattern_of_columns({{0}, {2}, {0, 1}, {1, 2}});
  const ColumnColoring coloring(path, 4);
  check_valid(coloring, path);
  CHECK(coloring.colors() == 2);
}

TEST_CASE("random patterns are coloured validly") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::srand(seed);
    constexpr Index n = 40;
    std::vector<std::vector<Index>> columns(n);
    for (auto& rows : columns)
      for (Index i = 0; i < n; ++i)
        if (std::rand() % 15 == 0) rows.push_back(i);
    const ColumnPattern pattern = pattern_of_columns(columns);
    const ColumnColoring coloring(pattern, n);
    check_valid(coloring, pattern);
    CHECK(coloring.colors() < n / 2);
  }
}

TEST_CASE("the empty pattern has no colours") { CHECK(ColumnColoring(ColumnPattern{}, 0).colors() == 0); }

TEST_CASE("a pattern that can't be one is refused") {
  CHECK_THROWS_AS(ColumnColoring(band_pattern(5, 1, 1), 6), std::invalid_argument);
  for (const auto& columns : std::vector<std::vector<std::vector<Index>>>{
           {{0}, {2}}, {{-1}, {1}}, {{1, 0}, {1}}, {{0, 0}, {1}}})  // outside, negative, not ascending, twice
    CHECK_THROWS_AS(ColumnColoring(pattern_of_columns(columns), 2), std::invalid_argument);
  CHECK_THROWS_AS(ColumnColoring(ColumnPattern{{0, 3, 2}, {0, 1}}, 2), std::invalid_argument);
  CHECK_THROWS_AS(ColumnColoring<>(ColumnPattern{{}, {}}, 2), std::invalid_argument);
}
