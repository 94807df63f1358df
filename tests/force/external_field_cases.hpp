// What external_field.test.cpp and external_field.full.cpp share.
#pragma once

#include <phistep/autodiff.hpp>
#include <phistep/force/external_field.hpp>
#include <phistep/particles/bodies/particles.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <stdexcept>

#include "support/catch.hpp"

using namespace phistep;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace external_field_cases {

inline Eigen::Matrix3Xd some_positions() {
  Eigen::Matrix3Xd r(3, 4);
  r << 0.3, -0.7, 0.2, 1.1, 0.4, -0.6, 0.5, 0.1, -0.4, 0.2, -0.3, 0.6;
  return r;
}
/// V = k (x⁴ + y² z) cos(ωt), F = −∇V
inline const auto quartic = [](const auto& r, auto t) {
  std::remove_cvref_t<decltype(r)> f = r;
  f[0] = -4 * r[0] * r[0] * r[0] * std::cos(2 * t);
  f[1] = -2 * r[1] * r[2] * std::cos(2 * t);
  f[2] = -1 * r[1] * r[1] * std::cos(2 * t);
  return f;
};
inline const auto potential = [](const auto& r, auto t) {
  return (r[0] * r[0] * r[0] * r[0] + r[1] * r[1] * r[2]) * std::cos(2 * t);
};

template <class S, class F>
auto force_on(F& force, const S& y, double t) {
  auto out = make_rate<S>(y);
  const UnitMass mass;
  add_force(force, t, Blocks<S>::view(y, std::tuple{mass}), NoMemory{}, out);
  return out.force;
}

struct Analytic {
  Vector3d operator()(const Vector3d& r, double t) const { return quartic(r, t); }
  Eigen::Matrix3d jacobian(const Vector3d& r, double t) const {
    Eigen::Matrix3d K;
    K << -12 * r[0] * r[0], 0, 0, 0, -2 * r[2], -2 * r[1], 0, -2 * r[1], 0;
    return K * std::cos(2 * t);
  }
};

}  // namespace external_field_cases
