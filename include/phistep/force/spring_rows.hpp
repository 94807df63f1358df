/// @file
/// The forces of many springs, row by row: each particle sums over all its springs, so that every spring is worked out
/// twice and nothing is scattered. Threads then change no bit, and a row's arithmetic fills whole registers.
///
/// Particles are renumbered once, in an order in which neighbours stand close (linear/node_order.hpp); positions are copied
/// into that order a little before they are needed, and sums added to the user's force. As many rows as a register has lanes
/// make a chunk, padded to its longest row (SELL: Kreutzer et al., SIAM J. Sci. Comput. 36 (2014) C401). In a regular mesh
/// the other ends of a column of a chunk mostly are consecutive particles: these need neither indices nor a gather.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/core/simd.hpp"
#include "phistep/core/simd_math.hpp"
#include "phistep/core/version.hpp"
#include "phistep/linear/node_order.hpp"

#ifdef _OPENMP
#include <omp.h>
#endif

namespace phistep::inline PHISTEP_ABI {

/// Has a workspace: one object serves one caller at a time, a copy has its own.
template <class Scalar, int dim, bool damped>
class SpringRows {
  static constexpr std::size_t lanes = native_width<Scalar>;
  using P = Pack<Scalar, native_width<Scalar>>;
  using Vector = std::array<P, dim>;
  using Slot = std::int32_t;  // a particle's new number
  static constexpr bool may_be_quads = dim > 1 && dim <= 4;
  /// Springs from which threads are woken: that takes some 5 µs, a spring 3 ns.
  static constexpr std::size_t parallel_from = 10'000;

 public:
  /// Whether rows take less time than a loop over the springs, which works out each spring once. With 4 and more lanes they
  /// do from some 100 springs on (0.55 … 0.8 of it at 1000); 2 lanes need a tenth to a quarter more time, but stay at it
  /// where the loop leaves the caches, and for two threads: 10,000. Numbers without lanes are left to the loop.
  [[nodiscard]] static bool suits(std::size_t springs, std::ptrdiff_t particles) {
    constexpr std::size_t least = lanes >= 4 ? 256 : parallel_from;
    return lanes > 1 && springs >= least && springs < std::size_t{1} << 28 &&
           particles < std::numeric_limits<Slot>::max();
  }
  [[nodiscard]] bool empty() const { return chunk_.empty(); }

  /// @param particles  more than any spring names, less than 2³¹
  void build(const auto& springs, std::ptrdiff_t particles) {
    springs_ = springs.size();
    const std::vector<Slot> slot = number(springs, particles);
    const std::size_t n = user_.size();
    std::vector<std::size_t> start(n + 1, 0);
    for_each_end(springs, slot, [&](Slot i, Slot, const auto&) { ++start[static_cast<std::size_t>(i) + 1]; });
    for (std::size_t i = 0; i < n; ++i) start[i + 1] += start[i];
    std::vector<End> ends(start.back());
    std::vector<std::size_t> at(start.begin(), start.end() - 1);
    Slot farthest = 0;
    for_each_end(springs, slot, [&](Slot i, Slot j, const auto& s) {
      const auto k = static_cast<Scalar>(s.stiffness);
      ends[at[static_cast<std::size_t>(i)]++] = {j, k, k * static_cast<Scalar>(s.length)};
      farthest = std::max(farthest, j - i);
    });
    for (std::size_t i = 0; i < n; ++i)
      std::stable_sort(&ends[start[i]], &ends[0] + start[i + 1],
                       [](const End& a, const End& b) { return a.other < b.other; });
    const std::size_t chunks = (n + lanes - 1) / lanes;
    stride_ = chunks * lanes;
    lead_ = jumps() ? chunks : std::min(chunks, static_cast<std::size_t>(farthest) / lanes + 2);
    lay_out(start, ends, true);
    // A gather from the arrays of coordinates takes longer than one of whole particles.
    quads_ = may_be_quads && index_.size() > lanes * column_.size() / 2;
    if (quads_) lay_out(start, ends, false);
    place_.assign(stride_ * (quads_ ? 4 : dim) * (damped ? 2 : 1), Scalar{0});
  }

  /// f += the springs' forces; arrays of dim components a particle in the user's order.
  /// @param still  not null: flags of particles whose force is not wanted
  /// @param c      of the dashpots [force·time/length]
  void add(const Scalar* r, const Scalar* v, const std::uint8_t* still, Scalar c, Scalar* f) {
    if constexpr (may_be_quads)
      if (quads_) return add_to<true>(r, v, still, c, f);
    add_to<false>(r, v, still, c, f);
  }

 private:
  struct End {
    Slot other;
    Scalar k, kL;
  };
  /// One spring of each row of a chunk.
  struct Column {
    Slot at;             // ≥ 0: the first of consecutive other ends; else ~ where their numbers stand in index_
    std::int32_t k, kL;  // where the constants stand in constant_; ~ where one serves all lanes
  };

  static void for_each_end(const auto& springs, const std::vector<Slot>& slot, auto&& visit) {
    for (const auto& s : springs) {
      const Slot i = slot[static_cast<std::size_t>(s.i)], j = slot[static_cast<std::size_t>(s.j)];
      visit(i, j, s);
      visit(j, i, s);
    }
  }
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
    user_.resize(n);
    for (std::size_t i = 0; i < slot.size(); ++i)
      if (slot[i] >= 0) {
        slot[i] = close[static_cast<std::size_t>(slot[i])];
        user_[static_cast<std::size_t>(slot[i])] = static_cast<Slot>(i);
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
  /// Whether the new order leads all over the user's arrays. Positions are then copied in a pass of its own: two such
  /// streams at a time overtax the translation of addresses (10 ms a step rather than 6, at 333,000 particles).
  [[nodiscard]] bool jumps() const {
    std::size_t far = 0;
    for (std::size_t i = 1; i < user_.size(); ++i) far += std::abs(user_[i] - user_[i - 1]) > 512 ? 1 : 0;
    return far > user_.size() / 4;
  }

  void lay_out(const std::vector<std::size_t>& start, const std::vector<End>& ends, bool find_consecutive) {
    const std::size_t n = user_.size();
    chunk_.assign(1, 0);
    column_.clear(), index_.clear(), constant_.clear();
    std::array<std::int32_t, 2> latest{-1, -1};  // constants that served all lanes
    const auto put_constants = [&](const std::array<End, lanes>& column, Scalar End::*which, std::int32_t& last) {
      const Scalar first = column[0].*which;
      const auto here = static_cast<std::int32_t>(constant_.size());
      if (std::all_of(column.begin(), column.end(), [&](const End& e) { return e.*which == first; })) {
        if (last >= 0 && constant_[static_cast<std::size_t>(last)] == first) return ~last;
        constant_.push_back(first);
        return ~(last = here);
      }
      for (const End& e : column) constant_.push_back(e.*which);
      return here;
    };
    for (std::size_t first = 0; first < n; first += lanes) {
      std::size_t longest = 0;
      for (std::size_t i = first; i < std::min(n, first + lanes); ++i)
        longest = std::max(longest, start[i + 1] - start[i]);
      for (std::size_t c = 0; c < longest; ++c) {
        const auto has = [&](std::size_t i) { return i < n && c < start[i + 1] - start[i]; };
        std::size_t some = first;
        while (!has(some)) ++some;
        // A row is padded by springs from the particle to itself, which have no force, like one beside them for the rest.
        std::array<End, lanes> column;
        for (std::size_t l = 0; l < lanes; ++l) {
          const std::size_t i = first + l;
          column[l] = ends[start[has(i) ? i : some] + c];
          if (!has(i)) column[l].other = static_cast<Slot>(i);
        }
        bool consecutive = find_consecutive;
        for (std::size_t l = 1; l < lanes; ++l)
          consecutive = consecutive && column[l].other == column[0].other + static_cast<Slot>(l);
        Column put{column[0].other, 0, 0};
        if (!consecutive) {
          put.at = ~static_cast<Slot>(index_.size());
          for (const End& e : column) index_.push_back(e.other);
        }
        put.k = put_constants(column, &End::k, latest[0]);
        put.kL = put_constants(column, &End::kL, latest[1]);
        column_.push_back(put);
      }
      chunk_.push_back(column_.size());
    }
  }

  template <bool quads>
  void add_to(const Scalar* r, const Scalar* v, const std::uint8_t* still, Scalar c, Scalar* f) {
    const std::size_t chunks = chunk_.size() - 1;
#ifdef _OPENMP
#pragma omp parallel if (springs_ >= parallel_from)
#endif
    {
      std::size_t first = 0, last = chunks;
#ifdef _OPENMP
      const auto team = static_cast<std::size_t>(omp_get_num_threads()),
                 me = static_cast<std::size_t>(omp_get_thread_num());
      first = chunks * me / team, last = chunks * (me + 1) / team;
#endif
      // Positions a little ahead, while they are in the cache; what neighbouring threads need, before anything else.
      const std::size_t shared = last - first > lead_ ? last - lead_ : first;
      std::size_t next = std::min(first + lead_, shared);
      for (std::size_t b = first; b < next; ++b) take<quads>(b, r, v);
      for (std::size_t b = shared; b < last; ++b) take<quads>(b, r, v);
#ifdef _OPENMP
#pragma omp barrier
#endif
      for (std::size_t b = first; b < last; ++b) {
        if (next < shared) take<quads>(next++, r, v);
        add_chunk<quads>(b, still, c, f);
      }
    }
  }

  template <bool quads>
  void take(std::size_t chunk, const Scalar* r, const Scalar* v) {
    const std::size_t first = chunk * lanes, last = std::min(first + lanes, user_.size());
    const auto copy = [&](const Scalar* from, Scalar* to) {
      for (std::size_t s = first; s < last; ++s) {
        const Scalar* const x = from + std::ptrdiff_t{dim} * user_[s];
        for (std::size_t a = 0; a < dim; ++a) to[quads ? 4 * s + a : a * stride_ + s] = x[a];
      }
    };
    copy(r, place_.data());
    if constexpr (damped) copy(v, velocities<quads>());
  }
  template <bool quads>
  [[nodiscard]] Scalar* velocities() {
    return place_.data() + stride_ * (quads ? 4 : dim);
  }
  /// f(a) for every axis a, as a constant: arrays of packs stay in registers.
  static void each_axis(auto&& f) {
    [&]<std::size_t... a>(std::index_sequence<a...>) { (f(std::integral_constant<std::size_t, a>{}), ...); }
    (std::make_index_sequence<dim>{});
  }
  template <bool quads>
  [[nodiscard]] Vector consecutive(const Scalar* from, std::size_t slot) const {
    if constexpr (quads) {
      std::array<Slot, lanes> slots;
      for (std::size_t l = 0; l < lanes; ++l) slots[l] = static_cast<Slot>(slot + l);
      return gather<true>(from, slots.data());
    } else {
      Vector x;
      each_axis([&](auto a) { x[a] = P::load(from + a * stride_ + slot); });
      return x;
    }
  }
  template <bool quads>
  [[nodiscard]] Vector gather(const Scalar* from, const Slot* slots) const {
    Vector x;
    if constexpr (quads) {
      const FourPacks<P> four = gather4<P>(from, slots);
      each_axis([&](auto a) {
        if constexpr (a == 0) x[a] = four.x;
        else if constexpr (a == 1) x[a] = four.y;
        else if constexpr (a == 2) x[a] = four.z;
        else x[a] = four.w;
      });
    } else {
      each_axis([&](auto a) { x[a] = P::gather(from + a * stride_, slots); });
    }
    return x;
  }
  template <bool quads>
  [[nodiscard]] Vector others(const Scalar* from, const Column& column) const {
    if constexpr (!quads)
      if (column.at >= 0) return consecutive<false>(from, static_cast<std::size_t>(column.at));
    return gather<quads>(from, index_.data() + ~column.at);
  }
  [[nodiscard]] P constant(std::int32_t at) const {
    return at >= 0 ? P::load(constant_.data() + at) : P{constant_[static_cast<std::size_t>(~at)]};
  }

  /// Each operation is odd or even in r_j − r_i: what two ends find are exact opposites.
  template <bool quads>
  [[gnu::flatten]] void add_chunk(std::size_t chunk, const std::uint8_t* still, Scalar c, Scalar* f) {
    const std::size_t first = chunk * lanes, last = std::min(first + lanes, user_.size());
    if (still != nullptr && std::all_of(&user_[first], &user_[0] + last, [still](Slot i) { return still[i] != 0; }))
      return;
    const Scalar* const place = place_.data();
    const Scalar* const velocity = velocities<quads>();
    const Vector r = consecutive<quads>(place, first);
    [[maybe_unused]] Vector v;
    if constexpr (damped) v = consecutive<quads>(velocity, first);
    Vector sum;
    each_axis([&](auto a) { sum[a] = P{0}; });
    for (std::size_t w = chunk_[chunk]; w < chunk_[chunk + 1]; ++w) {
      const Column column = column_[w];
      Vector d = others<quads>(place, column);
      P square{0};
      each_axis([&](auto a) {
        d[a] -= r[a];
        square = fma(d[a], d[a], square);
      });
      // f/ℓ = k − k L/ℓ + c d·Δv/ℓ²
      const P inverse = rsqrt(square);
      P pull = fma(-constant(column.kL), inverse, constant(column.k));
      if constexpr (damped) {
        const Vector u = others<quads>(velocity, column);
        P along{0};
        each_axis([&](auto a) { along = fma(d[a], u[a] - v[a], along); });
        pull += P{c} * along * (inverse * inverse);
      }
      pull = select(square == P{0}, P{0}, pull);  // no direction, hence no force: the symmetric choice
      each_axis([&](auto a) { sum[a] = fma(pull, d[a], sum[a]); });
    }
    std::array<std::array<Scalar, lanes>, dim> sums;
    each_axis([&](auto a) { sum[a].store(sums[a].data()); });
    for (std::size_t s = first; s < last; ++s) {
      Scalar* const to = f + std::ptrdiff_t{dim} * user_[s];
      for (std::size_t a = 0; a < dim; ++a) to[a] += sums[a][s - first];
    }
  }

  std::size_t springs_ = 0;
  std::vector<Slot> user_;          // the particle at each place of the new order
  std::vector<std::size_t> chunk_;  // where its columns begin
  std::vector<Column> column_;
  std::vector<Slot> index_;
  std::vector<Scalar> constant_;
  bool quads_ = false;  // whole particles side by side, four numbers each, rather than arrays of coordinates
  std::size_t stride_ = 0, lead_ = 0;  // places; chunks that positions are copied ahead
  std::vector<Scalar> place_;          // positions, and velocities where damped, in the new order
};

}  // namespace phistep::inline PHISTEP_ABI
