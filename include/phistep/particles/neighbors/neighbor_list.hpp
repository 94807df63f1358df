/// @file
/// Who is near whom: a Verlet list [L. Verlet, Phys. Rev. 159, 98 (1967)].
///
/// Particles and their periodic images stand in *slots*, sorted by cells of space, so that what is near in space is near
/// in memory. A slot says whose image it is and how often that one is shifted:
///     x(slot) = r(particle) + image · length of the box.
/// Every particle that moves has a *row*: the slots of all particles within the range, itself excluded, but its own images
/// included. Rows are filled up to a multiple of the vector width by a *dummy*, which stands so far away that it is beyond any
/// cutoff. Each slot whose number is a multiple of 8,192 is one.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A box without its number type: which axes repeat, and how often a coordinate has to be shifted to lie in the first period.
/// An axis that does not repeat is open: `lower` and `length` do not bind there.
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
    std::int32_t first;                ///< in the chunk's `near` or `far`
    std::array<std::int32_t, 3> ends;  ///< of its parts, from there, with the dummies
  };
  static constexpr std::int32_t dummy_every = 8192;
  static constexpr std::int32_t rows_per_chunk = 512;

  std::vector<Slot> slots;
  std::vector<Row> rows;      ///< in the slots' order
  std::vector<Chunk> chunks;  ///< the first `chunk_count` are in use
  std::size_t chunk_count = 0;
  std::int32_t pad = 1;  ///< a row's parts are filled up to a multiple of it, a power of two
  std::int32_t particles = 0;

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
  [[nodiscard]] std::uint64_t pairs_tested() const {
    std::uint64_t sum = 0;
    for (std::size_t c = 0; c < chunk_count; ++c) sum += chunks[c].tested;
    return sum;
  }
  /// Entries of all rows: a pair of two particles that move counts twice.
  [[nodiscard]] std::uint64_t pairs_listed() const {
    std::uint64_t sum = 0;
    for (std::size_t c = 0; c < chunk_count; ++c) sum += chunks[c].listed;
    return sum;
  }
};

}}  // namespace phistep::PHISTEP_ABI
