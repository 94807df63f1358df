/// @file
/// Positions in the order of a list's slots, four numbers each: what a kernel gathers from.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/neighbors/neighbor_list.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// x y z and one number for the force's own use (0 until it is set), of each slot. Structs of four:
/// on AVX-512, eight of them loaded and transposed take half the time of three gathers from separate arrays.
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
  const auto put = [&](Eigen::Index s) {
    const std::int32_t ahead = list.slots[static_cast<std::size_t>(std::min(s + 24, slots - 1))].particle;
    prefetch(r + dim * std::ptrdiff_t{std::max(ahead, 0)});
    const NeighborList::Slot& slot = list.slots[static_cast<std::size_t>(s)];
    Scalar* const to = places.data() + 4 * s;
    if (slot.particle < 0) return std::fill_n(to, dim, far_away<Scalar>()), void();
    for (std::size_t a = 0; a < dim; ++a)
      to[a] = static_cast<Scalar>(static_cast<double>(r[static_cast<std::size_t>(slot.particle) * dim + a]) +
                                  slot.image[a] * domain.length[a]);
  };
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
  for (Eigen::Index s = 0; s < slots; ++s) put(s);
}

/// f(row, its chunk, the chunk's number), threads sharing the chunks. What f throws, a law of the user's own
/// perhaps, passes through.
void for_each_row(const NeighborList& list, auto&& f) {
  Relay relay;
  const auto chunks = static_cast<std::ptrdiff_t>(list.chunk_count);
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
  for (std::ptrdiff_t c = 0; c < chunks; ++c)
    relay.run([&] {
      const NeighborList::Chunk& chunk = list.chunks[static_cast<std::size_t>(c)];
      for (std::int32_t k = chunk.rows[0]; k < chunk.rows[1]; ++k) {
        const NeighborList::Row& row = list.rows[static_cast<std::size_t>(k)];
        f(row, chunk, static_cast<std::size_t>(c));
      }
    });
  relay.rethrow();
}

}}  // namespace phistep::PHISTEP_ABI
