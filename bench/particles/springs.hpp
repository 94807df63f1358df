/// @file
/// A triangulated sheet of unit masses on springs, explicit: G × G particles that stand 5 % off their places, 3 springs
/// each, k = 100, Δt = 1e-3, symplectic Euler. Handed over in three orders.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace bench {

enum class Order { sorted, springs_shuffled, particles_shuffled };

struct Sheet {
  static constexpr double k = 100, dt = 1e-3;
  Eigen::Matrix3Xd r;
  std::vector<std::pair<int, int>> ends;
  std::vector<double> lengths;  ///< at rest
  std::vector<int> place;       ///< particle `place[n]` is the n-th of the sheet, row by row

  [[nodiscard]] std::size_t springs() const { return ends.size(); }

  Sheet(int side, Order order) : place(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> shake(-0.05, 0.05);
    std::iota(place.begin(), place.end(), 0);
    if (order == Order::particles_shuffled) std::shuffle(place.begin(), place.end(), random);
    random.seed(2);
    const auto at = [&](int x, int y) { return place[static_cast<std::size_t>(y * side + x)]; };
    r.resize(3, side * side);
    const auto join = [&](int i, int j, double length) {
      ends.emplace_back(i, j);
      lengths.push_back(length);
    };
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const double a = shake(random), b = shake(random), c = shake(random);
        r.col(at(x, y)) << x + a, y + b, c;
        if (x + 1 < side) join(at(x, y), at(x + 1, y), 1);
        if (y + 1 < side) join(at(x, y), at(x, y + 1), 1);
        if (x + 1 < side && y + 1 < side) join(at(x, y), at(x + 1, y + 1), std::sqrt(2.0));
      }
    if (order == Order::sorted) return;
    // Springs shuffled; or, where the particles are numbered anyhow, by their first particle.
    std::vector<std::size_t> turn(springs());
    std::iota(turn.begin(), turn.end(), std::size_t{0});
    if (order == Order::springs_shuffled) std::shuffle(turn.begin(), turn.end(), random);
    else
      std::stable_sort(turn.begin(), turn.end(), [&](std::size_t a, std::size_t b) {
        return std::min(ends[a].first, ends[a].second) < std::min(ends[b].first, ends[b].second);
      });
    const auto old_ends = ends;
    const auto old_lengths = lengths;
    for (std::size_t s = 0; s < springs(); ++s) {
      ends[s] = old_ends[turn[s]];
      lengths[s] = old_lengths[turn[s]];
    }
  }
};

/// Somebody who steps a sheet.
struct SheetStepper {
  virtual ~SheetStepper() = default;
  virtual void step(int times) = 0;
  [[nodiscard]] virtual Eigen::Matrix3Xd positions() const = 0;  ///< in the order handed over
};

// By hand, phistep not used; nothing is checked and a failed step is not undone.
[[nodiscard]] std::unique_ptr<SheetStepper> hand_scatter(const Sheet& sheet);  ///< spring by spring, 3-wide structs
[[nodiscard]] std::unique_ptr<SheetStepper> hand_rows(const Sheet& sheet);     ///< particle by particle, 8 at a time

}  // namespace bench
