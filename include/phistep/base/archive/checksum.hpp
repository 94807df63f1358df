/// @file
/// CRC-64 with the ECMA-182 polynomial, reflected (the one of xz): sees every error that spans at most 64 bits, and all
/// but 2⁻⁶⁴ of the others. The same on every machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// CRC-64/XZ; of "123456789" it is 995dc9bbdf1939fa.
/// @param before  that of what came before, if the bytes come in pieces
[[nodiscard]] inline std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t before = 0) {
  static constexpr auto table = [] {
    std::array<std::uint64_t, 256> all{};
    for (std::uint64_t i = 0; i < all.size(); ++i) {
      std::uint64_t crc = i;
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc % 2 == 1 ? 0xc96c5795d7870f42u : 0);
      all[static_cast<std::size_t>(i)] = crc;
    }
    return all;
  }();
  std::uint64_t crc = ~before;
  for (const std::byte byte : bytes)
    crc = table[static_cast<std::size_t>((crc ^ static_cast<std::uint64_t>(byte)) & 0xff)] ^ crc >> 8;
  return ~crc;
}

}}  // namespace phistep::PHISTEP_ABI
