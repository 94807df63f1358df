#pragma once

// What every fuzz target shares: bytes made into numbers, and demands that end the program. A target is a file
// <name>.fuzz.cpp with LLVMFuzzerTestOneInput; replay.cpp calls it for the files of corpus/<name>.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fuzz {

/// What must hold, whatever the bytes.
inline void demand(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "demand not met: %s\n", what);
  std::abort();
}

/// Numbers out of bytes; zeros once they are used up, so that every prefix of an input is one too.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_{data}, left_{size} {}

  [[nodiscard]] std::size_t left() const { return left_; }
  [[nodiscard]] const std::uint8_t* rest() const { return data_; }
  void skip(std::size_t n) { n = std::min(n, left_), data_ += n, left_ -= n; }

  std::uint8_t byte() {
    if (left_ == 0) return 0;
    --left_;
    return *data_++;
  }
  bool flag() { return byte() % 2 == 1; }
  /// 0 … n − 1
  int below(int n) { return byte() % n; }
  std::uint64_t word() {
    std::uint64_t x = 0;
    for (int k = 0; k < 8; ++k) x = x << 8 | byte();
    return x;
  }
  /// In [low, high], 16 bits fine.
  double between(double low, double high) {
    const int high_byte = byte(), x = 256 * high_byte + byte();
    return low + (high - low) * x / 65535;
  }
  /// low … high by powers.
  double scaled(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  /// Anything: mostly tame, sometimes a NaN, an infinity, a denormal, a huge or tiny number, any bits.
  double wild() {
    constexpr double inf = std::numeric_limits<double>::infinity();
    constexpr std::array special{0.0,
                                 -0.0,
                                 1.0,
                                 -1.0,
                                 inf,
                                 -inf,
                                 std::numeric_limits<double>::quiet_NaN(),
                                 std::numeric_limits<double>::denorm_min(),
                                 std::numeric_limits<double>::min(),
                                 std::numeric_limits<double>::max(),
                                 std::numeric_limits<double>::lowest(),
                                 std::numeric_limits<double>::epsilon(),
                                 1e-300,
                                 1e300,
                                 1e16,
                                 1e-16,
                                 0.1,
                                 1e150,
                                 -1e-150,
                                 9.3e18};
    switch (below(8)) {
      case 0:
        return special[byte() % special.size()];
      case 1:
        return std::bit_cast<double>(word());
      case 2:
        return scaled(1e-20, 1e20);
      case 3:
        return -scaled(1e-20, 1e20);
      default:
        return between(-4, 4);
    }
  }
  /// As often tame as not.
  double number(double low, double high) { return below(16) == 0 ? wild() : between(low, high); }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

[[nodiscard]] inline bool same_bits(const auto& a, const auto& b) {
  return a.size() == b.size() &&
         (a.size() == 0 ||
          std::memcmp(a.data(), b.data(), sizeof(*a.data()) * static_cast<std::size_t>(a.size())) == 0);
}

}  // namespace fuzz
