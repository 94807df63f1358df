#pragma once

// What the restarts of motions share, quick and full.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "contract/restart.hpp"
#include "contract/states.hpp"

namespace restart_motion {

using namespace phistep;
using restart::check;
using restart::loosely;
using restart::Steps;
using Vec = Eigen::VectorXd;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

inline const Steps even{0.05}, uneven{0.05, false};
template <class Solver = void>
auto tolerant() {
  return newton<Solver>({.rtol = 1e-4, .atol = 1e-6});
}
template <class F, class... More>
auto steps(F f, More... more) {
  return [=](const auto& y) { return PhiStepper{y, f, more...}; };
}
inline Motion<Vec> six() {
  const auto block = [](const states::Six& x) { return Vec(Eigen::Map<const Vec>(x.data(), 6)); };
  return {block(states::positions), block(states::velocities)};
}
/// A pull that moves with time and ignores the velocity: Verlet carries it, with the time that it belongs to.
struct Driven : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = true;
  void add(auto t, const auto& y, auto& out) const { out.force -= (4 + std::sin(3 * t)) * y.r; }
};
struct Pull : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(auto /*t*/, const auto& y, auto& out) const { out.force -= 2 * y.r + y.r.cwiseProduct(y.r); }
};
struct Wind : ForceTerm {
  static constexpr bool uses_velocity = true, uses_time = true;
  void add(auto t, const auto& y, auto& out) const {
    out.force -= 0.1 * y.v;
    out.force.array() += 0.2 * std::cos(t);
  }
};

/// −k r − |r|² r − c v for each particle alone.
struct Well {
  Vector3d operator()(const Vector3d& r, const Vector3d& v) const { return -r - r.squaredNorm() * r - 0.2 * v; }
};
struct WellWithJacobian : Well {
  [[nodiscard]] MotionJacobian<Matrix3d> jacobian(const Vector3d& r, const Vector3d& /*v*/) const {
    const Matrix3d I = Matrix3d::Identity();
    return {-I - (r.squaredNorm() * I + 2 * r * r.transpose()), -0.2 * I};
  }
};
struct Shear {
  Vector3d operator()(const Vector3d& r) const { return {-2 * r[0] + r[1], -r[1], -3 * r[2]}; }
  [[nodiscard]] Matrix3d jacobian(const Vector3d&) const { return Matrix3d{{-2, 1, 0}, {0, -1, 0}, {0, 0, -3}}; }
};
inline Motion<Matrix3Xd> crowd() {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Motion<Matrix3Xd> y{Matrix3Xd(3, 5), Matrix3Xd(3, 5)};
  for (auto& x : y.r.reshaped()) x = normal(random);
  for (auto& x : y.v.reshaped()) x = normal(random);
  return y;
}

/// Pulls to anchors that follow once the stretch exceeds `slip`.
struct Slider : ForceTerm {
  static constexpr const char* name = "slider";
  struct Memory {
    Vec anchor;
    int commits = 0;
    std::vector<double> slips;
    void archive(auto& ar) { ar("anchor", anchor, "commits", commits, "slips", slips); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  double k = 30, slip = 0.05;
  static void begin(double, double, const auto& y, Memory& m) {
    if (m.anchor.size() == 0) m.anchor = y.r;
  }
  void add(double, const auto& y, const Memory& m, auto& out) const { out.force -= k * (y.r - m.anchor); }
  void commit(double t, const auto& y, Memory& m) const {
    const Vec before = m.anchor;
    for (Eigen::Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - slip, y.r[i] + slip);
    if (before != m.anchor) m.slips.push_back(t);
    ++m.commits;
  }
};
/// A kick drawn anew for each step.
struct Noise : ForceTerm {
  static constexpr const char* name = "noise";
  struct Memory {
    std::mt19937_64 random{5};
    double kick = 0;
    void archive(auto& ar) { ar(random, kick); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void begin(double, double, const auto&, Memory& m) {
    m.kick = std::uniform_real_distribution<double>{-1, 1}(m.random);
  }
  static void add(double, const auto&, const Memory& m, auto& out) { out.force.array() += m.kick; }
  static void commit(double, const auto&, Memory&) {}
};

}  // namespace restart_motion
