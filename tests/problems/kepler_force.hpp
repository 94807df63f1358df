#pragma once

#include <Eigen/Core>

#include <cmath>

namespace problems {

/// −r/|r|³ in the plane.
struct KeplerForce {
  using Vector = Eigen::Vector2d;

  template <class T>
  static void acceleration(const T* r, T* a) {
    const T square = r[0] * r[0] + r[1] * r[1], w = T(-1) / (square * std::sqrt(square));
    a[0] = w * r[0], a[1] = w * r[1];
  }
  Vector operator()(const Vector& r) const {
    Vector a;
    acceleration(r.data(), a.data());
    return a;
  }
  [[nodiscard]] Eigen::Matrix2d jacobian(const Vector& r) const {
    const double d = r.norm();
    return (3 * r * r.transpose() / (d * d) - Eigen::Matrix2d::Identity()) / (d * d * d);
  }
};

}  // namespace problems
