/// @file
/// The data of springs row by row (spring_rows.hpp): the particles' new order, and for each chunk of `lanes` rows the other ends and
/// constants of their springs.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <tuple>
#include <utility>
#include <vector>

#include "phistep/linear/network/node_order.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Scalar, std::size_t lanes>
class SpringLayout {
 public:
  using Slot = std::int32_t;  ///< a particle's new number
  /// One spring of each row of a chunk.
  struct Column {
    Slot at;             // ≥ 0: the first of consecutive other ends; else ~ where their numbers stand in index
    std::int32_t k, kL;  // where the constants stand in constant; ~ where one serves all lanes
  };

  std::vector<Slot> user;             ///< the particle at each place of the new order
  std::vector<std::size_t> chunk{0};  ///< where its columns begin
  std::vector<Column> column;
  std::vector<Slot> index;
  std::vector<Scalar> constant;
  std::size_t lead = 0;        ///< chunks that a chunk's other ends reach, and one more
  bool mixed = false;          ///< few columns have consecutive other ends: then all have indices
  std::vector<Slot> place_of;  ///< of each of the user's particles, −1: no springs; empty unless the new order jumps

  SpringLayout() = default;
  /// @param particles  their number, above every index in a spring, below 2³¹
  /// @param may_mix    false: `mixed` stays false
  SpringLayout(const auto& springs, std::ptrdiff_t particles, bool may_mix) {
    std::vector<Slot> slot = number(springs, particles);
    const std::size_t n = user.size();
    Slot farthest = 0;
    Ends ends;
    ends.build(static_cast<std::ptrdiff_t>(n), [&](auto&& put) {
      for (const auto& s : springs) {
        const Slot i = slot[static_cast<std::size_t>(s.i)], j = slot[static_cast<std::size_t>(s.j)];
        const auto k = static_cast<Scalar>(s.stiffness);
        put(i, j, {k, k * static_cast<Scalar>(s.length)});
        farthest = std::max(farthest, std::abs(j - i));
      }
    });
    ends.sort([](const End& a, const End& b) {
      return std::tie(a.other, a.mark.k, a.mark.kL) < std::tie(b.other, b.mark.k, b.mark.kL);
    });
    const std::size_t chunks = (n + lanes - 1) / lanes;
    lead = std::min(chunks, static_cast<std::size_t>(farthest) / lanes + 2);
    if (jumps()) place_of = std::move(slot);
    lay_out(ends, true);
    mixed = may_mix && index.size() > lanes * column.size() / 2;
    if (mixed) lay_out(ends, false);
  }

 private:
  struct Constants {
    Scalar k, kL;
  };
  using Ends = PairGraph<Constants>;
  using End = typename Ends::Edge;
  /// Numbers the particles that have springs.
  [[nodiscard]] std::vector<Slot> number(const auto& springs, std::ptrdiff_t particles) {
    std::vector<Slot> slot(static_cast<std::size_t>(particles), -1);
    for (const auto& s : springs) slot[static_cast<std::size_t>(s.i)] = slot[static_cast<std::size_t>(s.j)] = 0;
    std::size_t n = 0;
    for (Slot& s : slot)
      if (s == 0) s = static_cast<Slot>(n++);
    std::vector<NodePair> pairs;
    pairs.reserve(springs.size());
    for (const auto& s : springs)
      pairs.emplace_back(slot[static_cast<std::size_t>(s.i)], slot[static_cast<std::size_t>(s.j)]);
    std::vector<Slot> close = close_order(n, pairs);
    even_out(close, pairs);
    user.resize(n);
    for (std::size_t i = 0; i < slot.size(); ++i)
      if (slot[i] >= 0) {
        slot[i] = close[static_cast<std::size_t>(slot[i])];
        user[static_cast<std::size_t>(slot[i])] = static_cast<Slot>(i);
      }
    return slot;
  }
  /// Where rows beside each other differ so much in length that a tenth of all columns would be padding, sorts them by
  /// length, within windows small against the caches.
  static void even_out(std::vector<Slot>& close, const std::vector<NodePair>& pairs) {
    constexpr std::size_t window = 32 * lanes;
    const std::size_t n = close.size();
    std::vector<Slot> node(n), length(n, 0);
    for (std::size_t i = 0; i < n; ++i) node[static_cast<std::size_t>(close[i])] = static_cast<Slot>(i);
    for (const auto& [i, j] : pairs) ++length[static_cast<std::size_t>(i)], ++length[static_cast<std::size_t>(j)];
    const auto length_of = [&](Slot i) { return length[static_cast<std::size_t>(i)]; };
    const auto part = [&](std::size_t first, std::size_t size) {
      const auto begin = node.begin() + static_cast<std::ptrdiff_t>(first);
      return std::pair{begin, begin + static_cast<std::ptrdiff_t>(std::min(size, n - first))};
    };
    std::size_t padded = 0;
    for (std::size_t first = 0; first < n; first += lanes) {
      const auto [begin, end] = part(first, lanes);
      const Slot longest = *std::max_element(begin, end, [&](Slot i, Slot j) { return length_of(i) < length_of(j); });
      padded += lanes * static_cast<std::size_t>(length_of(longest));
    }
    if (padded < 2 * pairs.size() * 11 / 10) return;
    for (std::size_t first = 0; first < n; first += window) {
      const auto [begin, end] = part(first, window);
      std::stable_sort(begin, end, [&](Slot i, Slot j) { return length_of(i) > length_of(j); });
    }
    for (std::size_t i = 0; i < n; ++i) close[static_cast<std::size_t>(node[i])] = static_cast<Slot>(i);
  }
  /// Whether the new order leads all over the user's arrays.
  [[nodiscard]] bool jumps() const {
    std::size_t distant = 0;
    for (std::size_t i = 1; i < user.size(); ++i) distant += std::abs(user[i] - user[i - 1]) > 512 ? 1 : 0;
    return distant > user.size() / 4;
  }

  void lay_out(const Ends& ends, bool find_consecutive) {
    const std::size_t n = user.size();
    chunk.assign(1, 0);
    column.clear(), index.clear(), constant.clear();
    std::array<std::int32_t, 2> latest{-1, -1};  // constants that served all lanes
    const auto put_constants = [&](const std::array<End, lanes>& row, Scalar Constants::*which, std::int32_t& last) {
      const Scalar first = row[0].mark.*which;
      const auto here = static_cast<std::int32_t>(constant.size());
      if (std::all_of(row.begin(), row.end(), [&](const End& e) { return e.mark.*which == first; })) {
        if (last >= 0 && constant[static_cast<std::size_t>(last)] == first) return ~last;
        constant.push_back(first);
        return ~(last = here);
      }
      for (const End& e : row) constant.push_back(e.mark.*which);
      return here;
    };
    for (std::size_t first = 0; first < n; first += lanes) {
      std::size_t longest = 0;
      for (std::size_t i = first; i < std::min(n, first + lanes); ++i) longest = std::max(longest, ends.of(i).size());
      for (std::size_t c = 0; c < longest; ++c) {
        const auto has = [&](std::size_t i) { return i < n && c < ends.of(i).size(); };
        std::size_t some = first;
        while (!has(some)) ++some;
        // A row is padded by springs from the particle to itself, like one beside them but for their length at rest: with
        // 0 they have no force.
        std::array<End, lanes> row;
        for (std::size_t l = 0; l < lanes; ++l) {
          const std::size_t i = first + l;
          row[l] = ends.of(has(i) ? i : some)[c];
          if (!has(i)) row[l].other = static_cast<Slot>(i), row[l].mark.kL = 0;
        }
        bool consecutive = find_consecutive;
        for (std::size_t l = 1; l < lanes; ++l)
          consecutive = consecutive && row[l].other == row[0].other + static_cast<Slot>(l);
        Column put{row[0].other, 0, 0};
        if (!consecutive) {
          put.at = ~static_cast<Slot>(index.size());
          for (const End& e : row) index.push_back(e.other);
        }
        put.k = put_constants(row, &Constants::k, latest[0]);
        put.kL = put_constants(row, &Constants::kL, latest[1]);
        column.push_back(put);
      }
      chunk.push_back(column.size());
    }
  }
};

}}  // namespace phistep::PHISTEP_ABI
