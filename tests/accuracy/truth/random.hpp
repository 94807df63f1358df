#pragma once

// Random numbers that are the same with every standard library.

#include <cmath>
#include <cstdint>
#include <random>

namespace truth {

class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_{seed} {}
  [[nodiscard]] double uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  [[nodiscard]] double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// low … high, both included
  [[nodiscard]] int integer(int low, int high) { return low + static_cast<int>(uniform() * (high - low + 1)); }
  [[nodiscard]] double power_of_ten(double low, double high) { return std::pow(10.0, uniform(low, high)); }
  [[nodiscard]] double normal() {
    double sum = -6;
    for (int k = 0; k < 12; ++k) sum += uniform();
    return sum;
  }
  [[nodiscard]] bool chance(double p) { return uniform() < p; }

 private:
  std::mt19937_64 bits_;
};

}  // namespace truth
