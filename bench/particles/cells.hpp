/// @file
/// All pairs within a range in a periodic cube, the plain way: what neighbour lists are checked against.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace bench {

/// The shortest image of a difference.
[[nodiscard]] inline Eigen::Vector3d nearest(const Eigen::Vector3d& d, double side) {
  return d.array() - side * (d.array() / side).round();
}

/// f(i, j, d) with d = the nearest image of r_j − r_i, for every pair with |d| < range, once.
void for_each_pair(const Eigen::Matrix3Xd& r, double side, double range, auto&& f) {
  const int n = std::max(1, static_cast<int>(side / range));
  if (n < 3) throw std::invalid_argument("a box of less than three cells");
  const auto coordinate = [&](double x) {
    return std::clamp(static_cast<int>((x - side * std::floor(x / side)) / side * n), 0, n - 1);
  };
  const auto cell = [n](int x, int y, int z) {
    const auto turn = [n](int c) { return (c + n) % n; };
    return static_cast<std::size_t>((turn(z) * n + turn(y)) * n + turn(x));
  };
  std::vector<std::vector<Eigen::Index>> members(static_cast<std::size_t>(n) * static_cast<std::size_t>(n * n));
  for (Eigen::Index i = 0; i < r.cols(); ++i)
    members[cell(coordinate(r(0, i)), coordinate(r(1, i)), coordinate(r(2, i)))].push_back(i);
  const double square = range * range;
  const auto visit = [&](Eigen::Index i, Eigen::Index j) {
    const Eigen::Vector3d d = nearest(r.col(j) - r.col(i), side);
    if (d.squaredNorm() < square) f(i, j, d);
  };
  // A cell with itself, and with half of its 26 neighbours.
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const auto& own = members[cell(x, y, z)];
        for (std::size_t a = 0; a < own.size(); ++a)
          for (std::size_t b = a + 1; b < own.size(); ++b) visit(own[a], own[b]);
        for (int k = 14; k < 27; ++k)
          for (const Eigen::Index j : members[cell(x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1)])
            for (const Eigen::Index i : own) visit(i, j);
      }
}

}  // namespace bench
