#include <phistep/linear/network/node_order.hpp>

#include <numeric>
#include <random>

#include "support/catch.hpp"

using namespace phistep;

namespace {
/// A grid's edges, its nodes numbered by `number`.
std::vector<NodePair> grid(std::int32_t side, const std::vector<std::int32_t>& number) {
  std::vector<NodePair> edges;
  const auto at = [&](std::int32_t x, std::int32_t y) { return number[static_cast<std::size_t>(y * side + x)]; };
  for (std::int32_t y = 0; y < side; ++y)
    for (std::int32_t x = 0; x < side; ++x) {
      if (x + 1 < side) edges.emplace_back(at(x, y), at(x + 1, y));
      if (y + 1 < side) edges.emplace_back(at(x, y), at(x, y + 1));
    }
  return edges;
}
std::int32_t bandwidth(const std::vector<NodePair>& edges, const std::vector<std::int32_t>& number) {
  std::int32_t widest = 0;
  for (const auto& [i, j] : edges)
    widest = std::max(widest, std::abs(number[static_cast<std::size_t>(i)] - number[static_cast<std::size_t>(j)]));
  return widest;
}
bool is_permutation(std::vector<std::int32_t> number) {
  std::sort(number.begin(), number.end());
  for (std::size_t i = 0; i < number.size(); ++i)
    if (number[i] != static_cast<std::int32_t>(i)) return false;
  return true;
}
}  // namespace

TEST_CASE("a shuffled grid regains a narrow band, a good numbering is left alone") {
  constexpr std::int32_t side = 20;
  std::vector<std::int32_t> given(side * side);
  std::iota(given.begin(), given.end(), 0);
  CHECK(close_order(given.size(), grid(side, given)) == given);
  auto shuffled = given;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(3));
  const auto edges = grid(side, shuffled);
  CHECK(bandwidth(edges, given) > 200);
  const auto number = close_order(given.size(), edges);
  CHECK(is_permutation(number));
  CHECK(bandwidth(edges, number) <=
        2 * side);  // neighbouring levels of a breadth-first search, of at most `side` nodes
}

TEST_CASE("separate parts and lone nodes are numbered too") {
  const auto number = cuthill_mckee(7, {{5, 1}, {3, 0}});
  CHECK(is_permutation(number));
  CHECK(std::abs(number[5] - number[1]) == 1);
  CHECK(std::abs(number[3] - number[0]) == 1);
  CHECK(cuthill_mckee(0, {}).empty());
}
