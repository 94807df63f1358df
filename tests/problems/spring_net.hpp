#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <cmath>
#include <vector>

namespace problems {

/// A free 3×3 net of springs in the plane, diagonals included, of unequal masses, stretched and set moving; with a
/// dashpot beside every spring if asked for.
struct SpringNet {
  using State = phistep::Motion<Eigen::VectorXd>;
  static constexpr int side = 3, particles = side * side;

  [[nodiscard]] static std::vector<phistep::Spring> springs() {
    std::vector<phistep::Spring> list;
    const auto join = [&list](int x0, int y0, int x1, int y1) {
      if (x1 < 0 || x1 >= side || y1 >= side) return;
      list.push_back({x0 + side * y0, x1 + side * y1, 20.0 + x0 + 2 * y0, std::hypot(x1 - x0, y1 - y0)});
    };
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        join(x, y, x + 1, y);
        join(x, y, x, y + 1);
        join(x, y, x + 1, y + 1);
        join(x, y, x - 1, y + 1);
      }
    return list;
  }
  [[nodiscard]] static auto elastic() { return phistep::spring_network<2>(springs()); }
  [[nodiscard]] static auto damped() { return phistep::spring_network<2>(springs(), phistep::SpringDamping{0.3}); }

  /// One mass a component.
  [[nodiscard]] static Eigen::VectorXd masses() {
    Eigen::VectorXd m(2 * particles);
    for (int i = 0; i < particles; ++i) m[2 * i] = m[2 * i + 1] = 1 + 0.25 * i;
    return m;
  }
  [[nodiscard]] static State start() {
    State y{Eigen::VectorXd(2 * particles), Eigen::VectorXd(2 * particles)};
    for (int i = 0; i < particles; ++i) {
      const int x = i % side, row = i / side;
      y.r.segment<2>(2 * i) = Eigen::Vector2d{1.2 * x + 0.1 * row, 0.9 * row - 0.05 * x * row};
      y.v.segment<2>(2 * i) = Eigen::Vector2d{0.5 - 0.4 * row, 0.3 * x};
    }
    return y;
  }
  [[nodiscard]] static Eigen::Vector2d momentum(const State& y) {
    Eigen::Vector2d p = Eigen::Vector2d::Zero();
    const Eigen::VectorXd m = masses();
    for (int i = 0; i < particles; ++i) p += m[2 * i] * y.v.segment<2>(2 * i);
    return p;
  }
};

}  // namespace problems
