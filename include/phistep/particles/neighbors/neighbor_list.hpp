/// @file
/// Particles near each other: a Verlet list [L. Verlet, Phys. Rev. 159, 98 (1967)].
///
/// Particles and their periodic images stand in *slots*, sorted by cells of space, so that what is near in space is near
/// in memory. A slot says whose image it is and how often that one is shifted:
/// x(slot) = r(particle) + image · length of the box.
/// Every particle that moves has a *row*: the slots of all particles within the range, itself excluded, but its own images
/// included. Rows are filled up to a multiple of the vector width by a *dummy*, which stands so far away that it is beyond any
/// cutoff. Each slot whose number is a multiple of 8,192 is one.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/pack.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// How wide a skin: from counts, not from a clock, so that a run is the same on every machine. A list to r_c + s that served m
// steps, with L entries and T distances computed for each particle, has cost
//
//     C(s) = p L + (b + q T)/m                                                                                    (1)
//
// a step and particle. With another skin L and T change as (r_c + s)^dim, and m as s.

/// What a list took, and how long it served.
struct ListUse {
  double listed = 0, tested = 0;  ///< a particle
  std::int32_t steps = 1;
};

/// The skin of the next list [length]: that of the last one, or one of the two that are √2 times as long and as short, whichever
/// (1) says is cheapest. Within 0.06 and 2 cutoffs, and not beyond `longest`.
template <int dim>
[[nodiscard]] double next_skin(double cutoff, double skin, const ListUse& use, double longest) {
  constexpr double p = 1, q = 1, b = 150;  // of one entry's share of the force
  constexpr double rung = 1.4142135623730951, worth = 0.97;
  const auto cost = [&](double s) {
    const double more = std::pow((cutoff + s) / (cutoff + skin), dim);
    return p * use.listed * more + (b + q * use.tested * more) * skin / (s * std::max(use.steps, 1));
  };
  double best = skin, least = worth * cost(skin);
  for (const double s : {skin / rung, skin * rung})
    if (s >= 0.06 * cutoff && s <= std::min(2 * cutoff, longest) && cost(s) < least) best = s, least = cost(s);
  return best;
}

/// A box without its number type. An axis that isn't periodic is open: `lower` and `length` do not bind there.
struct Domain {
  std::array<double, 3> lower{}, length{};  ///< [length]
  std::array<bool, 3> periodic{};

  bool operator==(const Domain&) const = default;

  /// k with x + k·length in [lower, lower + length], up to rounding. 0 on an open axis and for what is not a number.
  [[nodiscard]] std::int32_t image(std::size_t axis, double x) const {
    if (!periodic[axis]) return 0;
    const double k = -std::floor((x - lower[axis]) / length[axis]);
    return std::abs(k) < 1e9 ? static_cast<std::int32_t>(k) : 0;
  }
};

/// A cutoff for each pair of types.
struct TypeCutoffs {
  std::vector<std::int32_t> type;  ///< of each particle, N
  std::vector<double> cutoffs;     ///< types × types [length]; 0: not listed
  bool operator==(const TypeCutoffs&) const = default;
};

/// The domain of a `Box<Scalar, dim>`.
template <class Box>
[[nodiscard]] Domain domain_of(const Box& box) {
  Domain domain;
  for (std::size_t a = 0; a < box.is_periodic.size(); ++a) {
    domain.periodic[a] = box.is_periodic[a];
    if (!box.is_periodic[a]) continue;
    const auto axis = static_cast<std::ptrdiff_t>(a);
    domain.lower[a] = static_cast<double>(box.lower[axis]);
    domain.length[a] = static_cast<double>(box.upper[axis]) - static_cast<double>(box.lower[axis]);
  }
  return domain;
}

struct NeighborList {
  struct Slot {
    std::int32_t particle;              ///< the user's index; −1: a dummy
    std::array<std::int32_t, 3> image;  ///< in periods of the box, from where the user has it
  };
  /// Rows lie in chunks, the unit of work of a thread. Their number does not depend on that of threads.
  ///
  /// A neighbour takes two bytes, counted from a slot that serves the whole chunk: up to some million particles the cells
  /// around a chunk's rows hold fewer than 65,536. Where they don't, each of the three layers of cells has such a slot.
  struct Chunk {
    std::vector<std::uint16_t> offsets;  ///< of all rows, longer than what is in use
    std::array<std::int32_t, 3> base{};  ///< of each part of a row: the slot that 0 means, a dummy
    std::vector<std::int32_t> slots;     ///< unless it is empty, in the place of `offsets`: whole slots
    std::array<std::int32_t, 2> rows{};  ///< first, and one after the last
    std::uint64_t tested = 0, listed = 0;
  };
  struct Row {
    std::int32_t slot;                 ///< where its particle stands
    std::int32_t first;                ///< in the chunk's `offsets` or `slots`
    std::array<std::int32_t, 3> ends;  ///< of its parts, from there, with the dummies
  };
  static constexpr std::int32_t dummy_every = 8192;
  static constexpr std::int32_t rows_per_chunk = 512;

  std::vector<Slot> slots;
  std::vector<Row> rows;      ///< in the slots' order
  std::vector<Chunk> chunks;  ///< the first `chunk_count` are in use
  std::size_t chunk_count = 0;
  std::int32_t pad = 1;  ///< a row's parts are filled up to a multiple of it, a power of two

  [[nodiscard]] std::int32_t particle_of(std::int32_t slot) const {
    return slots[static_cast<std::size_t>(slot)].particle;
  }
  /// f(slot of a neighbour) for a row's, without the dummies.
  void for_each_neighbor(const Row& row, const Chunk& chunk, auto&& f) const {
    std::int32_t k = 0;
    for (std::size_t part = 0; part < 3; ++part)
      for (; k < row.ends[part]; ++k) {
        const auto at = static_cast<std::size_t>(row.first + k);
        const std::int32_t number = chunk.slots.empty() ? chunk.offsets[at] : chunk.slots[at];
        if (number != 0) f(chunk.base[part] + number);
      }
  }
  /// f(row, slot of a neighbour) for all of them, row after row.
  void for_each_neighbor(auto&& f) const {
    for (std::size_t c = 0; c < chunk_count; ++c)
      for (std::int32_t k = chunks[c].rows[0]; k < chunks[c].rows[1]; ++k) {
        const Row& row = rows[static_cast<std::size_t>(k)];
        for_each_neighbor(row, chunks[c], [&](std::int32_t slot) { f(row, slot); });
      }
  }
  /// Distances computed while it was built.
  [[nodiscard]] std::uint64_t pairs_tested() const { return total(&Chunk::tested); }
  /// Entries of all rows: a pair of two particles that move counts twice.
  [[nodiscard]] std::uint64_t pairs_listed() const { return total(&Chunk::listed); }

 private:
  [[nodiscard]] std::uint64_t total(std::uint64_t Chunk::*count) const {
    std::uint64_t sum = 0;
    for (std::size_t c = 0; c < chunk_count; ++c) sum += chunks[c].*count;
    return sum;
  }
};

/// x y z and one number for the force's own use (0 until it is set), of each slot. On AVX-512 eight such structs loaded and transposed take
/// half the time of three gathers.
template <class Scalar>
using Places = Eigen::Matrix<Scalar, 4, Eigen::Dynamic>;

/// Where a dummy stands, along each axis: beyond any cutoff, and with a finite square.
template <class Scalar>
[[nodiscard]] Scalar far_away() {
  return std::sqrt(std::numeric_limits<Scalar>::max()) / 4;
}

/// @param r  dim × N [length], in the user's order
template <int dim, class Scalar>
void gather_places(const NeighborList& list, const Scalar* r, const Domain& domain, Places<Scalar>& places) {
  const auto slots = static_cast<Eigen::Index>(list.slots.size());
  if (places.cols() < slots) places.setZero(4, slots + slots / 16);
  PHISTEP_DETAIL_OMP("omp parallel for schedule(static)")
  for (Eigen::Index s = 0; s < slots; ++s) {
    const std::int32_t ahead = list.slots[static_cast<std::size_t>(std::min(s + 24, slots - 1))].particle;
    prefetch(r + dim * std::ptrdiff_t{std::max(ahead, 0)});
    const NeighborList::Slot& slot = list.slots[static_cast<std::size_t>(s)];
    Scalar* const to = places.data() + 4 * s;
    if (slot.particle < 0) std::fill_n(to, dim, far_away<Scalar>());
    else
      for (std::size_t a = 0; a < dim; ++a)
        to[a] = static_cast<Scalar>(static_cast<double>(r[static_cast<std::size_t>(slot.particle) * dim + a]) +
                                    slot.image[a] * domain.length[a]);
  }
}

template <class P>
[[nodiscard]] FourPacks<P> broadcast_place(const typename P::Scalar* x) {
  return {P{x[0]}, P{x[1]}, P{x[2]}, P{x[3]}};
}
/// f(d, r²) for one at x and those in some slots of `all`, d = x − theirs; where tagged f(d, r², fourth number of x, theirs).
template <int dim, bool tagged, class P>
[[gnu::always_inline]] inline void with_pack(const FourPacks<P>& x, const auto* all, const auto* slots, auto&& f) {
  const FourPacks<P> other = gather4<P>(all, slots);
  P d[3] = {x.x - other.x, x.y - other.y, P{0}};
  P r2 = fma(d[0], d[0], d[1] * d[1]);
  if constexpr (dim == 3) d[2] = x.z - other.z, r2 = fma(d[2], d[2], r2);
  if constexpr (tagged) f(d, r2, x.w, other.w);
  else f(d, r2);
}
/// The same for a row's neighbours, as many at once as a P holds.
/// @param all  the places of the list's slots
template <int dim, bool tagged, class P>
[[gnu::always_inline]] inline void for_each_pack_of(const NeighborList::Row& row, const NeighborList::Chunk& chunk,
                                                    const typename P::Scalar* all, auto&& f) {
  using Scalar = typename P::Scalar;
  static constexpr std::array<std::uint16_t, 16> in_turn{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  alignas(64) Scalar few[4 * P::width];
  const auto x = broadcast_place<P>(all + std::ptrdiff_t{4} * row.slot);
  const bool counted = chunk.slots.empty();
  const std::uint16_t* which = counted ? chunk.offsets.data() + row.first : in_turn.data();
  std::int32_t k = 0;
  for (std::size_t part = 0; part < 3; ++part) {
    const Scalar* const from = counted ? all + std::ptrdiff_t{4} * chunk.base[part] : few;
    for (; k < row.ends[part]; k += P::width) {
      if (!counted)
        unrolled<P::width>([&](auto l) {
          const std::ptrdiff_t slot = chunk.slots[static_cast<std::size_t>(row.first + k + l)];
          Pack<Scalar, 4>::load(all + 4 * slot).store(few + 4 * l);
        });
      with_pack<dim, tagged>(x, from, which, f);
      if (counted) which += P::width;
    }
  }
}

/// f(number of a chunk), by threads. What f throws passes through.
void for_each_chunk(const NeighborList& list, auto&& f) {
  Relay relay;
  PHISTEP_DETAIL_OMP("omp parallel for schedule(static)")
  for (std::size_t c = 0; c < list.chunk_count; ++c) relay.run([&] { f(c); });
  relay.rethrow();
}
/// f(row, its chunk, the chunk's number), likewise.
void for_each_row(const NeighborList& list, auto&& f) {
  for_each_chunk(list, [&](std::size_t c) {
    const NeighborList::Chunk& chunk = list.chunks[c];
    for (std::int32_t k = chunk.rows[0]; k < chunk.rows[1]; ++k) f(list.rows[static_cast<std::size_t>(k)], chunk, c);
  });
}

}}  // namespace phistep::PHISTEP_ABI
