#pragma once

#include <Eigen/Core>

#include "problems/entries.hpp"

namespace problems {

/// The Belousov-Zhabotinskii reaction (Field & Noyes 1974; Hairer & Wanner, Solving ODEs II, sect. IV.10): a limit cycle of
/// period 303 whose components swing over up to five decades, with rates up to 1e5.
struct Oregonator {
  using State = Eigen::Vector3d;
  static constexpr double end = 360;

  [[nodiscard]] static State start() { return {1, 2, 3}; }
  template <class Y, class Out>
  static void rate(const Y& y, Out&& out) {
    out[0] = 77.27 * (y[1] + y[0] * (1 - 8.375e-6 * y[0] - y[1]));
    out[1] = (y[2] - (1 + y[0]) * y[1]) / 77.27;
    out[2] = 0.161 * (y[0] - y[2]);
  }
  template <class Y, class Put>
  static constexpr void entries(const Y& y, Put&& put) {
    put(0, 0, 77.27 * (1 - 2 * 8.375e-6 * y[0] - y[1])), put(1, 0, -y[1] / 77.27), put(2, 0, 0.161);
    put(0, 1, 77.27 * (1 - y[0])), put(1, 1, -(1 + y[0]) / 77.27);
    put(1, 2, 1 / 77.27), put(2, 2, -0.161);
  }
  State operator()(const State& y) const {
    State out;
    rate(y, out);
    return out;
  }
  [[nodiscard]] Eigen::Matrix3d jacobian(const State& y) const { return dense_jacobian<Oregonator>(y); }

  /// At t = 360, by Radau IIA in quadruple precision; the published values agree.
  [[nodiscard]] static State exact() {
    return {1.00081487031852268e+00, 1.22817852154988736e+03, 1.32055494284650450e+02};
  }
};

}  // namespace problems
