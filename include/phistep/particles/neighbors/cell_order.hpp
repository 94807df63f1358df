/// @file
/// Particles and their periodic images sorted by the cells of a grid, in time O(N) wherever they are.
///
/// There is no array of cells: sorted by key = (c_z n_y + c_y) n_x + c_x, the particles of cells beside each other in x follow each other,
/// and a pointer that only advances finds them. So empty space costs nothing. A cell's number is clamped to 0 … 2^20 − 1, for a particle at
/// 1e300: that keeps the order, so that particles in range of each other still are at most as many cells apart.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/particles/neighbors/neighbor_list.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Sorts by whole numbers in time O(n): digit by digit, the last first, each pass stable (D. E. Knuth, The Art of Computer Programming 3,
/// section 5.2.5). Threads share the passes; the order doesn't depend on them.
/// @tparam Keyed  has a key
template <class Keyed>
class RadixSort {
 public:
  /// Ascending by key; equal ones keep their order.
  /// @param top  no key is larger
  void operator()(std::vector<Keyed>& items, std::uint64_t top) {
    resize_with_spare(other_, items.size());
    next_.resize(thread_count());
    for (int shift = 0; shift < static_cast<int>(std::bit_width(top)); shift += digit) {
      const auto bin = [shift](const Keyed& item) { return (item.key >> shift) & (bins - 1); };
      const auto each_share = [&](const auto& f) { for_each_share(items.size(), 1, shared_from / 4, f); };
      for (auto& next : next_) next.fill(0);
      each_share([&](const Share& own) {
        for (std::size_t e = own.begin; e < own.end; ++e) ++next_[own.number][bin(items[e])];
      });
      std::uint32_t sum = 0;
      for (std::size_t b = 0; b < bins; ++b)
        for (auto& next : next_) sum += std::exchange(next[b], sum);
      each_share([&](const Share& own) {
        auto& next = next_[own.number];
        for (std::size_t e = own.begin; e < own.end; ++e) other_[next[bin(items[e])]++] = items[e];
      });
      items.swap(other_);
    }
  }

 private:
  static constexpr int digit = 11;  // bits
  static constexpr std::size_t bins = std::size_t{1} << digit;

  std::vector<Keyed> other_;
  std::vector<std::array<std::uint32_t, bins>> next_;  // of each share: where the next item of a bin goes
};

/// The sorted particles and images. What only the sort needs is given back after it.
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
    r_ = r, particles_ = static_cast<std::size_t>(particles), domain_ = domain;
    for (auto& x : x_) release(x);  // the sort may have that memory
    add_images(range);
    const std::size_t n = particles_ + images_.size();
    if (n >= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      throw std::invalid_argument("phistep: too many particles for one neighbour list");
    lay_grid(n, range);
    const std::uint64_t outside = n_[0] * n_[1] * n_[2];  // what is not a number has no place
    resize_with_spare(order_, n);
    for_each_share(n, 1, few, [&](const Share& own) {
      for (std::size_t e = own.begin; e < own.end; ++e) order_[e] = {key_of(entry(e).x), static_cast<std::uint32_t>(e)};
    });
    RadixSort<Keyed>{}(order_, outside);
    constexpr auto every = static_cast<std::size_t>(NeighborList::dummy_every);
    const std::size_t all = n == 0 ? 1 : n + 1 + (n - 1) / (every - 1);  // with the dummies
    resize_with_spare(slots, all);
    for (auto& x : x_) resize_with_spare(x, all + overhang);
    resize_with_spare(is_home_, all);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for_each_share(all, 1, few, [&](const Share& own) {
      for (std::size_t s = own.begin; s < own.end; ++s) {
        if (s % every == 0) {
          slots[s] = {-1, {}}, is_home_[s] = 0;
          for (auto& x : x_) x[s] = nan;
          continue;
        }
        const std::size_t rank = s - 1 - s / every;
        if (const std::size_t ahead = order_[std::min(rank + 24, n - 1)].entry; ahead < particles_)
          prefetch(r_ + ahead * dim);  // in the user's order, neighbours may be anywhere
        const Entry e = entry(order_[rank].entry);
        slots[s] = e.slot;
        is_home_[s] = order_[rank].entry < particles_;
        for (std::size_t a = 0; a < dim; ++a) x_[a][s] = e.x[a];
      }
    });
    cells_.clear();
    for (std::size_t rank = 0; rank < n; ++rank)
      if (cells_.empty() || cells_.back().key != order_[rank].key)
        cells_.push_back({order_[rank].key, static_cast<std::int32_t>(rank + 1 + rank / (every - 1))});
    if (cells_.empty() || cells_.back().key != outside)
      cells_.push_back({outside, static_cast<std::int32_t>(all)});  // the end
    release(order_);
    for (auto& x : x_) std::fill_n(x.begin() + static_cast<std::ptrdiff_t>(all), overhang, nan);
  }

  /// The last one is the end, and holds the slots of particles whose positions are not finite.
  [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }
  [[nodiscard]] const double* x(std::size_t axis) const { return x_[axis].data(); }
  /// Whether a slot holds the particle itself, and not a further image.
  [[nodiscard]] bool is_home(std::size_t slot) const { return is_home_[slot] != 0; }
  [[nodiscard]] std::uint64_t cells_along(std::size_t axis) const { return n_[axis]; }
  /// Into the first period.
  void bring_home(std::array<double, dim>& x) const {
    for (std::size_t a = 0; a < dim; ++a) x[a] += domain_.image(a, x[a]) * domain_.length[a];
  }
  /// Key of the cell that x is in; where x isn't finite, one past the last.
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
  static constexpr std::size_t few = shared_from / 16;  // particles that one thread takes alone

  /// A particle brought into the first period, or one of its further images.
  struct Entry {
    NeighborList::Slot slot;
    std::array<double, dim> x;
  };
  [[nodiscard]] Entry entry(std::size_t e) const {
    Entry one{slot_of(e), {}};
    for (std::size_t a = 0; a < dim; ++a) one.x[a] = place(one.slot, a);
    return one;
  }
  [[nodiscard]] NeighborList::Slot slot_of(std::size_t e) const {
    if (e >= particles_) return images_[e - particles_];
    NeighborList::Slot home{static_cast<std::int32_t>(e), {}};
    for (std::size_t a = 0; a < dim; ++a) home.image[a] = domain_.image(a, r_[e * dim + a]);
    return home;
  }
  [[nodiscard]] double place(const NeighborList::Slot& slot, std::size_t a) const {
    return r_[static_cast<std::size_t>(slot.particle) * dim + a] + slot.image[a] * domain_.length[a];
  }

  /// The images within the range of the box: along each axis those of all there are so far, so that corners are in.
  void add_images(double range) {
    images_.clear();
    for (std::size_t a = 0; a < dim; ++a) {
      if (!domain_.periodic[a]) continue;
      const double length = domain_.length[a], lower = domain_.lower[a];
      const std::size_t so_far = particles_ + images_.size();
      std::vector<std::vector<NeighborList::Slot>> found(thread_count());
      Relay relay;  // images may want more memory
      const auto find = [&](const Share& own) {
        for (std::size_t e = own.begin; e < own.end; ++e) {
          const double at = e < particles_ ? r_[e * dim + a] + domain_.image(a, r_[e * dim + a]) * length
                                           : place(images_[e - particles_], a);
          if ((at > lower + range && at < lower + length - range) || !std::isfinite(at)) continue;
          // 1e9 periods away a position is not wrapped, and has no images.
          const auto from = std::ceil(std::clamp((lower - range - at) / length, -8.0, 9.0));
          const auto to = std::floor(std::clamp((lower + length + range - at) / length, -9.0, 8.0));
          const NeighborList::Slot home = slot_of(e);
          for (auto k = static_cast<std::int32_t>(from); k <= static_cast<std::int32_t>(to); ++k) {
            if (k == 0) continue;
            found[own.number].push_back(home);
            found[own.number].back().image[a] += k;
          }
        }
      };
      for_each_share(so_far, 1, few, [&](const Share& own) { relay.run([&] { find(own); }); });
      relay.rethrow();
      std::size_t more = images_.size();
      for (const auto& some : found) more += some.size();
      if (images_.capacity() < more) images_.reserve(more + more / 16);
      for (const auto& some : found) images_.insert(images_.end(), some.begin(), some.end());
    }
  }

  /// Where the grid starts on each axis, and how many cells it has.
  void lay_grid(std::size_t n, double range) {
    std::array<double, dim> lowest, highest;
    lowest.fill(std::numeric_limits<double>::max());
    highest.fill(std::numeric_limits<double>::lowest());
    std::mutex one_at_a_time;
    for_each_share(n, 1, few, [&, none_low = lowest, none_high = highest](const Share& own) {
      auto low = none_low, high = none_high;
      for (std::size_t e = own.begin; e < own.end; ++e) {
        const Entry one = entry(e);
        for (std::size_t a = 0; a < dim; ++a)
          if (std::isfinite(one.x[a])) low[a] = std::min(low[a], one.x[a]), high[a] = std::max(high[a], one.x[a]);
      }
      const std::lock_guard lock{one_at_a_time};
      for (std::size_t a = 0; a < dim; ++a)
        lowest[a] = std::min(lowest[a], low[a]), highest[a] = std::max(highest[a], high[a]);
    });
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
      // Some particle is too far away: the cells are laid around the median particle.
      std::vector<double> all;
      for (std::size_t e = 0; e < n; ++e)
        if (const double x = entry(e).x[a]; std::isfinite(x)) all.push_back(x);
      const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
      std::nth_element(all.begin(), middle, all.end());
      origin_[a] = *middle - edge * static_cast<double>(most_cells / 2);
      n_[a] = most_cells;
    }
  }

  const double* r_ = nullptr;  // positions, during a call
  Domain domain_;
  std::size_t particles_ = 0;
  std::vector<NeighborList::Slot> images_;
  std::array<std::vector<double>, dim> x_;  // of the slots
  std::vector<std::uint8_t> is_home_;
  std::vector<Keyed> order_;
  std::vector<Cell> cells_;
  std::array<double, dim> origin_{}, per_cell_{};
  std::array<std::uint64_t, 3> n_{1, 1, 1};
};

}}  // namespace phistep::PHISTEP_ABI
