#pragma once

// Numbers for random scenes: the same on every machine and with every standard library.

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>

namespace contact_scenes {

class Chance {
 public:
  explicit Chance(std::uint64_t seed) : state_{seed} {}
  /// low ≤ x < high.
  double between(double low, double high) { return low + (high - low) * static_cast<double>(next() >> 11) * 0x1p-53; }
  /// The same with equal chances for equal ratios.
  double ratio(double low, double high) { return low * std::pow(high / low, between(0, 1)); }
  /// 0 … n − 1.
  int one_of(int n) { return static_cast<int>(next() % static_cast<std::uint64_t>(n)); }
  bool yes() { return one_of(2) == 1; }
  /// In a cube of half edge 1.
  Eigen::Vector3d vector() {
    const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
    return {x, y, z};
  }
  Eigen::Vector3d direction() {
    for (;;)
      if (const Eigen::Vector3d v = vector(); v.norm() > 0.2 && v.norm() < 1) return v.normalized();
  }

 private:
  std::uint64_t next() {  // splitmix64
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

/// A member's name and its numbers, for a report.
template <class... Part>
[[nodiscard]] std::string text(const Part&... part) {
  std::ostringstream out;
  (out << ... << part);
  return out.str();
}

}  // namespace contact_scenes
