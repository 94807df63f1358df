/// @file
/// Sorting by whole numbers, in time O(n): digit by digit, the last first, each pass stable (D. E. Knuth, The Art of Computer
/// Programming 3, section 5.2.5). Threads share the passes; the order doesn't depend on them.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "phistep/base/machine/scratch.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Sorts with a buffer as large as what is sorted.
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

}}  // namespace phistep::PHISTEP_ABI
