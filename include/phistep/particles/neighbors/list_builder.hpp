/// @file
/// From positions to a neighbour list: a pure function of positions, domain and which particles are held still, whatever
/// the number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/particles/neighbors/cell_order.hpp"
#include "phistep/particles/neighbors/neighbor_list.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam own_cutoffs  each pair of types has its own
template <int dim, bool own_cutoffs = false>
class ListBuilder : private CellOrder<dim> {
  using Order = CellOrder<dim>;

 public:
  using Order::is_home;
  using Order::sort;  ///< slots alone, for `around`
  /// @param r      dim × N [length]
  /// @param still  empty, or N: those that are not 0 have no row, and so two of them are no pair
  /// @param range  [length] of what is listed: closer than this
  /// @param pad    a row's parts are filled up to a multiple of it
  /// @param own    if own_cutoffs: what is listed is closer than the pair's cutoff + skin, at most `range`
  void build(const double* r, std::int32_t particles, const Domain& domain, const std::vector<std::uint8_t>& still,
             double range, std::int32_t pad, NeighborList& list, const TypeCutoffs& own = {}, double skin = 0) {
    sort(r, particles, domain, range, list.slots);
    if constexpr (own_cutoffs) set_ranges(own, skin, list.slots);
    list.pad = pad;
    list.rows.clear();
    for (std::size_t s = 0; s < list.slots.size(); ++s)
      if (is_home(s) && (still.empty() || still[static_cast<std::size_t>(list.slots[s].particle)] == 0))
        list.rows.push_back({static_cast<std::int32_t>(s), 0, {}});
    constexpr auto per_chunk = static_cast<std::size_t>(NeighborList::rows_per_chunk);
    list.chunk_count = (list.rows.size() + per_chunk - 1) / per_chunk;
    if (list.chunks.size() < list.chunk_count) list.chunks.resize(list.chunk_count);
    const P longest{range * range};
    for_each_chunk(list, [&](std::size_t c) {
      NeighborList::Chunk& chunk = list.chunks[c];
      release(chunk.slots);
      if (fill<Counted::from_one>(list, c, longest, chunk.offsets) ||
          fill<Counted::from_three>(list, c, longest, chunk.offsets))
        return;
      release(chunk.offsets);
      fill<Counted::from_none>(list, c, longest, chunk.slots);
    });
  }

 private:
  static constexpr int reach_x = Order::reach(0), reach = Order::reach(1);
  static constexpr std::size_t span = 2 * reach + 1, lines = dim == 3 ? span * span : span;
  using P = Pack<double, native_width<double>>;
  using Cells = std::vector<typename Order::Cell>;

  /// The slots in a line of cells along x.
  struct Line {
    std::size_t from = 0, to = 0;  ///< cells
    std::int32_t first = 0, last = 0;
  };

 public:
  /// What each caller of `around` keeps of the last slots: points that follow each other from cell to cell share the search.
  struct Around {
    std::uint64_t tested = 0;  ///< distances computed so far
    std::uint64_t key = ~std::uint64_t{0};
    std::array<Line, lines> lines_about;
    std::vector<std::int32_t> found;
  };
  /// The slots that are closer than `range`, at most that of `sort`, to a point; until the next call.
  [[nodiscard]] std::span<const std::int32_t> around(std::array<double, dim> point, double range, Around& own) const {
    this->bring_home(point);
    const std::uint64_t key = this->key_of(point);
    if (key == this->cells().back().key) return {};  // not a number
    if (key != own.key) find_lines(key, own.lines_about, key < own.key);
    own.key = key;
    std::int32_t candidates = 0;
    for (const Line& line : own.lines_about) candidates += line.last - line.first;
    own.tested += static_cast<std::uint64_t>(candidates);
    own.found.resize(std::max(own.found.size(), static_cast<std::size_t>(candidates) + P::width));
    P x[dim];
    for (std::size_t a = 0; a < dim; ++a) x[a] = P{point[a]};
    std::int32_t* out = own.found.data();
    for (const Line& line : own.lines_about) out = filter(x, line.first, line.last, P{range * range}, 0, out);
    return {own.found.data(), static_cast<std::size_t>(out - own.found.data())};
  }

 private:
  /// From one slot if that does, else from one of each layer, else whole slots.
  enum class Counted { from_one, from_three, from_none };

  /// @param to  offsets or slots of the chunk
  /// @return    whether its numbers can hold all
  template <Counted how, class Number>
  bool fill(NeighborList& list, std::size_t c, P longest, std::vector<Number>& to) const {
    constexpr auto per_chunk = static_cast<std::size_t>(NeighborList::rows_per_chunk);
    NeighborList::Chunk& chunk = list.chunks[c];
    const std::size_t begin = c * per_chunk, end = std::min(list.rows.size(), begin + per_chunk);
    chunk.rows = {static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end)};
    chunk.base = {};
    chunk.tested = chunk.listed = 0;
    const Cells& cells = this->cells();
    std::array<Line, lines> around;
    std::size_t cell = 0;
    bool fresh = true;
    std::int32_t used = 0;
    for (std::size_t r = begin; r < end; ++r) {
      NeighborList::Row& row = list.rows[r];
      row.first = used, row.ends = {};
      if (row.slot >= cells.back().first) continue;  // not a number: near no other
      if (fresh || row.slot >= cells[cell + 1].first) {
        if (fresh) cell = cell_of(row.slot);
        while (row.slot >= cells[cell + 1].first) ++cell;
        find_lines(cells[cell].key, around, fresh);
        if (fresh && how != Counted::from_none)  // no later row has a neighbour before these
          for (std::size_t part = 0; part < 3; ++part)
            chunk.base[part] =
                cells[around[how == Counted::from_one ? 0 : part * lines / 3].from].first & -NeighborList::dummy_every;
        fresh = false;
        if constexpr (how != Counted::from_none)
          for (std::size_t l = 0; l < lines; ++l)
            if (around[l].last > around[l].first &&
                around[l].last - chunk.base[3 * l / lines] > std::numeric_limits<Number>::max())
              return false;
      }
      std::int32_t candidates = 0;
      for (const Line& line : around) candidates += line.last - line.first;
      const auto needed =
          static_cast<std::size_t>(used) + static_cast<std::size_t>(candidates + P::width + 3 * list.pad);
      if (to.size() < needed) {
        // As much as the rows so far let expect, or a few rows: an ample reserve would be a third of all memory.
        const std::size_t done = r - begin,
                          expected = done < 32 ? 0 : static_cast<std::size_t>(used) * (end - begin) / done;
        resize_with_spare(to, std::max(needed, expected));
      }
      Number* const start = to.data() + used;
      Number *out = start, *part_start = start;
      P x[dim];
      for (std::size_t a = 0; a < dim; ++a) x[a] = P{this->x(a)[row.slot]};
      const auto square = [&] {
        if constexpr (own_cutoffs) return squares_of_[static_cast<std::size_t>(row.slot)];
        else return longest;
      }();
      for (std::size_t l = 0; l < lines; ++l) {
        const std::int32_t base = chunk.base[3 * l / lines];
        if (l == lines / 2) {  // its own: around itself
          out = filter(x, around[l].first, row.slot, square, base, out);
          out = filter(x, row.slot + 1, around[l].last, square, base, out);
        } else {
          out = filter(x, around[l].first, around[l].last, square, base, out);
        }
        chunk.listed += static_cast<std::uint64_t>(out - part_start);
        if (l + 1 == lines || (how == Counted::from_three && (3 * l + 3) % lines == 0))
          for (; ((out - start) & (list.pad - 1)) != 0; ++out) *out = 0;
        part_start = out;
        row.ends[3 * l / lines] = static_cast<std::int32_t>(out - start);
      }
      if (how != Counted::from_three) row.ends.fill(row.ends[2]);
      used += row.ends[2];
      chunk.tested += static_cast<std::uint64_t>(candidates - 1);
    }
    return true;
  }

  void set_ranges(const TypeCutoffs& own, double skin, const std::vector<NeighborList::Slot>& slots) {
    std::size_t types = 0;
    while (types * types < own.cutoffs.size()) ++types;
    const std::size_t each = slots.size() + P::width;  // packs are read beyond the last
    resize_with_spare(squares_, types * each);
    resize_with_spare(squares_of_, slots.size());
    for (std::size_t s = 0; s < slots.size(); ++s) {
      const std::int32_t i = slots[s].particle;
      const auto type = static_cast<std::size_t>(i < 0 ? 0 : own.type[static_cast<std::size_t>(i)]);
      squares_of_[s] = squares_.data() + type * each;
      for (std::size_t t = 0; t < types; ++t) {
        const double cutoff = own.cutoffs[t * types + type];
        squares_[t * each + s] = cutoff > 0 ? (cutoff + skin) * (cutoff + skin) : 0;
      }
    }
  }

  [[nodiscard]] std::size_t cell_of(std::int32_t slot) const {
    const Cells& cells = this->cells();
    const auto after = std::upper_bound(cells.begin(), cells.end(), slot,
                                        [](std::int32_t s, const auto& cell) { return s < cell.first; });
    return static_cast<std::size_t>(after - cells.begin()) - 1;
  }

  /// The lines about a cell; their ends only advance while the cells do.
  void find_lines(std::uint64_t key, std::array<Line, lines>& around, bool fresh) const {
    const Cells& cells = this->cells();
    const auto nx = static_cast<std::int64_t>(this->cells_along(0)),
               ny = static_cast<std::int64_t>(this->cells_along(1)),
               nz = static_cast<std::int64_t>(this->cells_along(2));
    const auto k = static_cast<std::int64_t>(key);
    const std::int64_t cx = k % nx, cy = k / nx % ny, cz = k / nx / ny;
    const std::int64_t from_x = std::max<std::int64_t>(cx - reach_x, 0), to_x = std::min(cx + reach_x, nx - 1) + 1;
    std::size_t l = 0;
    for (std::int64_t dz = dim == 3 ? -reach : 0; dz <= (dim == 3 ? reach : 0); ++dz)
      for (std::int64_t dy = -reach; dy <= reach; ++dy, ++l) {
        Line& line = around[l];
        const std::int64_t y = cy + dy, z = cz + dz;
        const std::int64_t line_key = (z * ny + y) * nx;
        const auto low = static_cast<std::uint64_t>(std::max<std::int64_t>(line_key + from_x, 0)),
                   high = static_cast<std::uint64_t>(std::max<std::int64_t>(line_key + to_x, 0));
        if (fresh) {
          const auto at = std::lower_bound(cells.begin(), cells.end(), low,
                                           [](const auto& one, std::uint64_t x) { return one.key < x; });
          line.from = line.to = std::min(static_cast<std::size_t>(at - cells.begin()), cells.size() - 1);
        }
        if (y < 0 || y >= ny || z < 0 || z >= nz) {
          line.first = line.last = 0;
          continue;
        }
        advance(cells, line.from, low);
        advance(cells, line.to, high);
        line.first = cells[line.from].first, line.last = cells[line.to].first;
      }
  }

  /// To the first cell whose key is not less; the end's is beyond all. Mostly one or two on, which no jump predicts.
  static void advance(const Cells& cells, std::size_t& cell, std::uint64_t key) {
    cell += cells[cell].key < key;
    cell += cells[cell].key < key;
    while (cells[cell].key < key) ++cell;
  }

  /// Appends those of the slots first … last − 1 that are closer to x than the range, counted from the base. Writes up to
  /// P::width − 1 beyond.
  /// @param square  of the range, or those of all slots
  template <class Number>
  Number* filter(const P* x, std::int32_t first, std::int32_t last, auto square, std::int32_t base, Number* out) const {
    const double* at[dim];
    unrolled<dim>([&](auto a) { at[a] = this->x(a); });
    for (std::int32_t s = first; s < last; s += P::width) {
      P d2{0};
      unrolled<dim>([&](auto a) {
        const P apart = x[a] - P::load(at[a] + s);
        d2 = fma(apart, apart, d2);
      });
      unsigned bits;
      if constexpr (std::is_pointer_v<decltype(square)>) bits = (d2 < P::load(square + s)).bits();
      else bits = (d2 < square).bits();
      if (last - s < P::width) bits &= (1u << (last - s)) - 1u;
      out = append(bits, s - base, out);
    }
    return out;
  }
  template <class Number>
  static Number* append(unsigned bits, std::int32_t s, Number* out) {
#if defined(__AVX512F__) && defined(__AVX512VL__)
    if constexpr (P::width == 8) {
      const __m256i slots = _mm256_add_epi32(_mm256_set1_epi32(s), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
      // Compressed in the register: compressing stores take 50 times as long on Zen 4.
      const __m256i kept = _mm256_maskz_compress_epi32(static_cast<__mmask8>(bits), slots);
      if constexpr (sizeof(Number) == 2) _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm256_cvtepi32_epi16(kept));
      else _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), kept);
      return out + std::popcount(bits);
    }
#endif
    unrolled<P::width>([&](auto l) {
      *out = static_cast<Number>(s + l);
      out += bits >> l & 1u;
    });
    return out;
  }

  std::vector<double> squares_;            // of the ranges from a type to each slot, type after type
  std::vector<const double*> squares_of_;  // of each slot's type: the first
};

}}  // namespace phistep::PHISTEP_ABI
