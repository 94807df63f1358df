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
#include <tuple>
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
  struct Cell {
    std::uint64_t key;
    std::int32_t first;  ///< slot
  };

  /// @param r  dim × N [length], any numbers
  void sort(const double* r, std::int32_t particles, const Domain& domain, double range,
            std::vector<NeighborList::Slot>& slots) {
    r_ = r, particles_ = static_cast<std::size_t>(particles), domain_ = &domain;
    add_images(range);
    const std::size_t n = particles_ + images_.size();
    if (n >= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      throw std::invalid_argument("phistep: too many particles for one neighbour list");
    lay_grid(n, range);
    const std::uint64_t outside = n_[0] * n_[1] * n_[2];  // what is not a number has no place
    order_.resize(n);
    std::uint64_t top = 0;
    for (std::size_t e = 0; e < n; ++e) {
      order_[e] = {key_of(entry(e).x), static_cast<std::uint32_t>(e)};
      top = std::max(top, order_[e].key);
    }
    radix_sort(top);
    slots.resize(n);
    for (auto& x : x_) x.resize(n + overhang);
    is_home_.resize(n);
    cells_.clear();
    for (std::size_t s = 0; s < n; ++s) {
#if defined(__GNUC__)
      if (const std::size_t ahead = order_[std::min(s + 24, n - 1)].entry; ahead < particles_)
        __builtin_prefetch(r_ + ahead * dim);  // in the user's order, neighbours may be anywhere
#endif
      const Entry e = entry(order_[s].entry);
      slots[s] = e.slot;
      is_home_[s] = order_[s].entry < particles_;
      for (std::size_t a = 0; a < dim; ++a) x_[a][s] = e.x[a];
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
  /// Of the cell where a place is; that of the end for what is not finite.
  [[nodiscard]] std::uint64_t key_of(const std::array<double, dim>& x) const {
    std::uint64_t key = 0;
    for (std::size_t a = dim; a-- > 0;) {
      if (!std::isfinite(x[a])) return n_[0] * n_[1] * n_[2];
      const double c = std::clamp((x[a] - origin_[a]) * per_cell_[a], 0.0, static_cast<double>(n_[a] - 1));
      key = key * n_[a] + static_cast<std::uint64_t>(c);
    }
    return key;
  }
  /// Cells within which a neighbour lies. Halved cells leave fewer candidates, and along x no more lines of cells.
  [[nodiscard]] static constexpr int reach(std::size_t axis) { return axis == 0 ? 2 : 1; }

  /// Numbers that may be read behind the last slot: not-a-numbers.
  static constexpr std::size_t overhang = 16;

 private:
  struct Keyed {
    std::uint64_t key;
    std::uint32_t entry;
  };
  static constexpr std::uint64_t most_cells = std::uint64_t{1} << 20;

  /// A particle brought into the first period, or one of its further images.
  struct Entry {
    NeighborList::Slot slot;
    std::array<double, dim> x;
  };
  [[nodiscard]] Entry entry(std::size_t e) const {
    if (e >= particles_) return images_[e - particles_];
    Entry home{{static_cast<std::int32_t>(e), {}}, {}};
    for (std::size_t a = 0; a < dim; ++a) std::tie(home.slot.image[a], home.x[a]) = home_of(e, a);
    return home;
  }
  /// How often particle e is shifted along an axis, and where it is then.
  [[nodiscard]] std::pair<std::int32_t, double> home_of(std::size_t e, std::size_t a) const {
    const double x = r_[e * dim + a];
    const std::int32_t image = domain_->image(a, x);
    return {image, x + image * domain_->length[a]};
  }

  /// The images within the range of the box: along each axis those of all there are so far, so that corners are in.
  void add_images(double range) {
    images_.clear();
    for (std::size_t a = 0; a < dim; ++a) {
      if (!domain_->periodic[a]) continue;
      const double length = domain_->length[a], lower = domain_->lower[a];
      const std::size_t so_far = particles_ + images_.size();
      for (std::size_t e = 0; e < so_far; ++e) {
        const double at = e < particles_ ? home_of(e, a).second : images_[e - particles_].x[a];
        if (at > lower + range && at < lower + length - range) continue;  // most of them
        if (!std::isfinite(at)) continue;
        // Positions beyond the numbers' resolution are not wrapped: those have no images.
        const auto from = std::ceil(std::clamp((lower - range - at) / length, -8.0, 9.0));
        const auto to = std::floor(std::clamp((lower + length + range - at) / length, -9.0, 8.0));
        const Entry home = entry(e);
        Entry image = home;
        for (auto k = static_cast<std::int32_t>(from); k <= static_cast<std::int32_t>(to); ++k) {
          if (k == 0) continue;
          image.x[a] = home.x[a] + k * length;
          image.slot.image[a] = home.slot.image[a] + k;
          images_.push_back(image);
        }
      }
    }
  }

  /// Where the grid starts on each axis, and how many cells it has.
  void lay_grid(std::size_t n, double range) {
    std::array<double, dim> lowest, highest;
    lowest.fill(std::numeric_limits<double>::max());
    highest.fill(std::numeric_limits<double>::lowest());
    for (std::size_t e = 0; e < n; ++e) {
      const Entry one = entry(e);
      for (std::size_t a = 0; a < dim; ++a)
        if (std::isfinite(one.x[a]))
          lowest[a] = std::min(lowest[a], one.x[a]), highest[a] = std::max(highest[a], one.x[a]);
    }
    for (std::size_t a = 0; a < dim; ++a) {
      const double edge = range / reach(a) * (1 + 1e-8);  // rounding moves none reach + 1 cells apart
      per_cell_[a] = 1 / edge;
      origin_[a] = lowest[a], n_[a] = 1;
      if (lowest[a] > highest[a]) continue;
      const double cells = (highest[a] - lowest[a]) / edge;
      if (cells < static_cast<double>(most_cells - 1)) {
        n_[a] = static_cast<std::uint64_t>(cells) + 1;
        continue;
      }
      // A particle is far away: the window is laid about the middle particle.
      std::vector<double> all;
      for (std::size_t e = 0; e < n; ++e)
        if (const double x = entry(e).x[a]; std::isfinite(x)) all.push_back(x);
      const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
      std::nth_element(all.begin(), middle, all.end());
      origin_[a] = *middle - edge * static_cast<double>(most_cells / 2);
      n_[a] = most_cells;
    }
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

  const double* r_ = nullptr;  // of the call
  const Domain* domain_ = nullptr;
  std::size_t particles_ = 0;
  std::vector<Entry> images_;
  std::array<std::vector<double>, dim> x_;  // of the slots
  std::vector<std::uint8_t> is_home_;
  std::vector<Keyed> order_, other_;
  std::vector<Cell> cells_;
  std::array<double, dim> origin_{}, per_cell_{};
  std::array<std::uint64_t, 3> n_{1, 1, 1};
};

}  // namespace phistep::inline PHISTEP_ABI
