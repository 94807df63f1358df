/// @file
/// A fingerprint of a state of particles that is a sum over them, so that the share of each can be added and taken off.
#pragma once

#include <cstdint>
#include <vector>

#include "phistep/base/numbers/fingerprint.hpp"
#include "phistep/base/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Σ over the numbers of all blocks of a state of particles, which may be taken particle by particle.
template <State S>
class ParticleFingerprint {
 public:
  using Plain = PlainState<S>;

  [[nodiscard]] static std::uint64_t of(const Plain& y) {
    return sum(y, [](const auto& block) {
      // Two floats share a word, which may be those of two particles.
      if constexpr (sizeof(ScalarOf<S>) < 8) return fingerprint_of_some(block.data(), block.size(), 0);
      else return fingerprint(block.data(), block.size());
    });
  }
  /// The share of one particle.
  [[nodiscard]] static std::uint64_t of(const Plain& y, Index particle) { return of(y, particle, particle); }
  /// The same if its index were another one.
  [[nodiscard]] static std::uint64_t of(const Plain& y, Index particle, Index index) {
    return sum(y, [particle, index](const auto& block) {
      const Index rows = block.rows();
      return fingerprint_of_some(block.data() + rows * particle, rows, rows * index);
    });
  }

  /// The fingerprint of all but some.
  [[nodiscard]] static std::uint64_t without(const Plain& y, const auto&... lists) {
    std::uint64_t all = of(y);
    const auto take_off = [&](const std::vector<std::int32_t>& some) {
      for (const std::int32_t i : some) all -= of(y, i);
    };
    (take_off(lists), ...);
    return all;
  }

 private:
  [[nodiscard]] static std::uint64_t sum(const Plain& y, auto&& of_block) {
    std::uint64_t total = 0, weight = 1;
    for_each_block(
        [&](auto, const auto& block) {
          total += weight * of_block(block);
          weight *= 0x9e3779b97f4a7c15u;
        },
        Blocks<S>::all(y));
    return total;
  }
};

}}  // namespace phistep::PHISTEP_ABI
