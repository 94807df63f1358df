/// @file
/// Who is near whom: a Verlet list [L. Verlet, Phys. Rev. 159, 98 (1967)].
///
/// Particles and their periodic images stand in *slots*, sorted by cells of space, so that what is near in space is near
/// in memory. A slot says whose image it is and how often that one is shifted:
///     x(slot) = r(particle) + image · length of the box.
/// Every particle that moves has a *row*: the slots of all particles within the range, itself excluded, but its own images
/// included. Rows are filled up to a multiple of the vector width by the *dummy* slot, which stands so far away that it
/// is beyond any cutoff; it comes after all others.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

struct NeighborList {
  struct Slot {
    std::int32_t particle;              ///< the user's index
    std::array<std::int32_t, 3> image;  ///< in periods of the box, from where the user has it
  };
  /// Rows lie in chunks, the unit of work of a thread. Their number does not depend on that of threads.
  struct Chunk {
    std::vector<std::int32_t> neighbors;  ///< of all rows, longer than what is in use
    std::array<std::int32_t, 2> rows{};   ///< first, and one after the last
    std::uint64_t tested = 0, listed = 0;
  };
  struct Row {
    std::int32_t slot;   ///< where its particle stands
    std::int32_t first;  ///< in the chunk's `neighbors`
    std::int32_t count;  ///< neighbours, without the dummies
  };
  static constexpr std::int32_t rows_per_chunk = 512;

  std::vector<Slot> slots;    ///< without the dummy
  std::vector<Row> rows;      ///< in the slots' order
  std::vector<Chunk> chunks;  ///< the first `chunk_count` are in use
  std::size_t chunk_count = 0;
  std::int32_t pad = 1;  ///< rows are filled up to a multiple of it; a power of two
  std::int32_t particles = 0;

  [[nodiscard]] std::int32_t dummy() const { return static_cast<std::int32_t>(slots.size()); }
  [[nodiscard]] std::int32_t padded(std::int32_t count) const { return (count + pad - 1) & -pad; }
  /// The neighbours of a row, without the dummies (which follow).
  [[nodiscard]] std::span<const std::int32_t> neighbors(std::size_t row) const {
    const Row& r = rows[row];
    const auto& all = chunks[row / static_cast<std::size_t>(rows_per_chunk)].neighbors;
    return {all.data() + r.first, static_cast<std::size_t>(r.count)};
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

}  // namespace phistep::inline PHISTEP_ABI
