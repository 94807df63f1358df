/// @file
/// Particles and their periodic images sorted by the cells of a grid, in time O(N) wherever they are.
///
/// There is no array of cells: sorted by key = (c_z n_y + c_y) n_x + c_x, the particles of a few cells beside each other in
/// x follow each other, and a pointer that only advances finds them. So empty space costs nothing, and one particle that
/// flew off to 1e300 spoils no grid. A cell's number is clamped to 0 … 2^20 − 1: that keeps the order, so that
/// particles in range of each other still are at most as many cells apart.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/neighbors/domain.hpp"
#include "phistep/neighbors/neighbor_list.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The sorted particles and images; a workspace, its buffers serve again.
template <int dim>
class CellOrder {
 public:
  static constexpr int reach = 2;  ///< cells within which a neighbour lies: an edge is half the range
  struct Cell {
    std::uint64_t key;
    std::int32_t first;  ///< slot
  };

  /// @param r  dim × N [length], any numbers
  void sort(const double* r, std::int32_t particles, const Domain& domain, double range,
            std::vector<NeighborList::Slot>& slots) {
    particles_ = particles;
    collect(r, domain, range);
    for (std::size_t a = 0; a < dim; ++a) lay_grid(a, range / reach * (1 + 1e-8));  // rounding moves none three cells apart
    const std::size_t n = entries_.size();
    order_.resize(n);
    std::uint64_t top = 0;
    const std::uint64_t outside = n_[0] * n_[1] * n_[2];  // what is not a number has no place
    for (std::size_t e = 0; e < n; ++e) {
      order_[e] = {key_of(e, outside), static_cast<std::uint32_t>(e)};
      top = std::max(top, order_[e].key);
    }
    radix_sort(top);
    slots.resize(n);
    for (std::size_t a = 0; a < dim; ++a) x_[a].resize(n + overhang);
    is_home_.resize(n);
    cells_.clear();
    for (std::size_t s = 0; s < n; ++s) {
      const std::uint32_t e = order_[s].entry;
      slots[s] = entries_[e];
      is_home_[s] = e < static_cast<std::uint32_t>(particles);
      for (std::size_t a = 0; a < dim; ++a) x_[a][s] = place_[a][e];
      if (cells_.empty() || cells_.back().key != order_[s].key)
        cells_.push_back({order_[s].key, static_cast<std::int32_t>(s)});
    }
    if (cells_.empty() || cells_.back().key != outside)
      cells_.push_back({outside, static_cast<std::int32_t>(n)});  // the end
    for (std::size_t a = 0; a < dim; ++a)
      std::fill_n(x_[a].begin() + static_cast<std::ptrdiff_t>(n), overhang, std::numeric_limits<double>::quiet_NaN());
  }

  /// The last one is the end, and holds the slots of particles whose positions are not finite.
  [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }
  [[nodiscard]] const double* x(std::size_t axis) const { return x_[axis].data(); }
  /// Whether a slot holds the particle itself, and not a further image.
  [[nodiscard]] bool is_home(std::size_t slot) const { return is_home_[slot] != 0; }
  [[nodiscard]] std::uint64_t cells_along(std::size_t axis) const { return n_[axis]; }

  /// Numbers that may be read behind the last slot: not-a-numbers.
  static constexpr std::size_t overhang = 16;

 private:
  struct Keyed {
    std::uint64_t key;
    std::uint32_t entry;
  };
  static constexpr std::uint64_t most_cells = std::uint64_t{1} << 20;

  /// The particles, then their images within the range of the box.
  void collect(const double* r, const Domain& domain, double range) {
    entries_.clear();
    for (auto& x : place_) x.clear();
    for (std::int32_t i = 0; i < particles_; ++i) {
      NeighborList::Slot slot{i, {}};
      for (std::size_t a = 0; a < dim; ++a) {
        const double x = r[static_cast<std::size_t>(i) * dim + a];
        slot.image[a] = domain.image(a, x);
        place_[a].push_back(x + slot.image[a] * domain.length[a]);
      }
      entries_.push_back(slot);
    }
    for (std::size_t a = 0; a < dim; ++a) {
      if (!domain.periodic[a]) continue;
      const double length = domain.length[a], lower = domain.lower[a];
      const std::size_t so_far = entries_.size();  // images in this axis of images in those before: the corners
      for (std::size_t e = 0; e < so_far; ++e) {
        const double x = place_[a][e];
        if (!std::isfinite(x)) continue;
        const auto from = static_cast<std::int32_t>(std::ceil(std::max(-8.0, (lower - range - x) / length)));
        const auto to = static_cast<std::int32_t>(std::floor(std::min(8.0, (lower + length + range - x) / length)));
        for (std::int32_t k = from; k <= to; ++k) {
          if (k == 0) continue;
          for (std::size_t b = 0; b < dim; ++b) place_[b].push_back(place_[b][e] + (b == a ? k * length : 0.0));
          entries_.push_back(entries_[e]);
          entries_.back().image[a] += k;
        }
      }
    }
    if (entries_.size() >= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      throw std::invalid_argument("phistep: too many particles for one neighbour list");
  }

  /// Where the grid starts on an axis, and how many cells it has.
  void lay_grid(std::size_t a, double edge) {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (const double x : place_[a])
      if (std::isfinite(x)) lowest = std::min(lowest, x), highest = std::max(highest, x);
    per_cell_[a] = 1 / edge;
    if (!(lowest <= highest)) lowest = highest = 0;
    const double cells = (highest - lowest) / edge;
    if (cells < static_cast<double>(most_cells - 1)) {
      origin_[a] = lowest;
      n_[a] = static_cast<std::uint64_t>(cells) + 1;
      return;
    }
    // Somebody is far away: the window is laid about the middle particle.
    scratch_.clear();
    for (const double x : place_[a])
      if (std::isfinite(x)) scratch_.push_back(x);
    const auto middle = scratch_.begin() + static_cast<std::ptrdiff_t>(scratch_.size() / 2);
    std::nth_element(scratch_.begin(), middle, scratch_.end());
    origin_[a] = *middle - edge * static_cast<double>(most_cells / 2);
    n_[a] = most_cells;
  }

  [[nodiscard]] std::uint64_t key_of(std::size_t e, std::uint64_t outside) const {
    std::uint64_t key = 0;
    for (std::size_t a = dim; a-- > 0;) {
      const double x = place_[a][e];
      if (!std::isfinite(x)) return outside;
      const double c = std::clamp((x - origin_[a]) * per_cell_[a], 0.0, static_cast<double>(n_[a] - 1));
      key = key * n_[a] + static_cast<std::uint64_t>(c);
    }
    return key;
  }

  /// Stable, by digits of 11 bits.
  void radix_sort(std::uint64_t top) {
    constexpr int digit = 11;
    other_.resize(order_.size());
    for (int shift = 0; shift < static_cast<int>(std::bit_width(top)); shift += digit) {
      std::array<std::uint32_t, 1u << digit> at{};
      const auto bin = [shift](std::uint64_t key) { return (key >> shift) & ((1u << digit) - 1); };
      for (const Keyed& k : order_) ++at[bin(k.key)];
      std::uint32_t sum = 0;
      for (std::uint32_t& x : at) sum += std::exchange(x, sum);
      for (const Keyed& k : order_) other_[at[bin(k.key)]++] = k;
      order_.swap(other_);
    }
  }

  std::int32_t particles_ = 0;
  std::vector<NeighborList::Slot> entries_;        // as collected
  std::array<std::vector<double>, dim> place_;     // of the entries
  std::array<std::vector<double>, dim> x_;         // of the slots
  std::vector<std::uint8_t> is_home_;
  std::vector<Keyed> order_, other_;
  std::vector<double> scratch_;
  std::vector<Cell> cells_;
  std::array<double, dim> origin_{}, per_cell_{};
  std::array<std::uint64_t, 3> n_{1, 1, 1};
};

}  // namespace phistep::inline PHISTEP_ABI
