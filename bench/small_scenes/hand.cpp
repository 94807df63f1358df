#include <bit>
#include <cmath>
#include <cstdint>

#include "hand.hpp"

namespace small_scenes {
namespace {
using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// ±0 for a finite x, else a NaN.
std::uint64_t trouble(double x) { return std::bit_cast<std::uint64_t>(x - x); }
bool none(std::uint64_t troubles) { return troubles << 1 == 0; }
bool finite(const Vector3d& x) { return none(trouble(x[0]) | trouble(x[1]) | trouble(x[2])); }
}  // namespace

Particle euler(Particle y, double mass, double dt, long steps) {
  const double h = dt / mass;
  for (long n = 0; n < steps; ++n) {
    const Particle next{y.r + dt * y.v, y.v - h * y.r};
    if (!(finite(next.r) && finite(next.v))) break;
    y = next;
  }
  return y;
}
Particle verlet(Particle y, double mass, double dt, long steps) {
  const double h = dt / 2 / mass;
  for (long n = 0; n < steps; ++n) {
    const Vector3d half = y.v - h * y.r;
    const Vector3d r = y.r + dt * half;
    const Particle next{r, half - h * r};
    if (!(finite(next.r) && finite(next.v))) break;
    y = next;
  }
  return y;
}

Beads euler(const Beads& start, const Net& net, double mass, double dt, long steps) {
  Beads y = start, next = start;
  const Index n = y.r.size();
  VectorXd f(n);
  const double h = dt / mass;
  for (long k = 0; k < steps; ++k) {
    f.setZero();
    add_forces(net, y.r.data(), f.data(), n);
    std::uint64_t troubles = 0;
    const double *const r = y.r.data(), *const v = y.v.data(), *const force = f.data();
    double *const r1 = next.r.data(), *const v1 = next.v.data();
    for (Index i = 0; i < n; ++i) {
      const double ri = r[i] + dt * v[i], vi = v[i] + h * force[i];
      r1[i] = ri;
      v1[i] = vi;
      troubles |= trouble(ri) | trouble(vi);
    }
    if (!none(troubles)) break;
    y.r.swap(next.r);
    y.v.swap(next.v);
  }
  return y;
}
Beads verlet(const Beads& start, const Net& net, double mass, double dt, long steps) {
  Beads y = start, next = start;
  const Index n = y.r.size();
  VectorXd f = VectorXd::Zero(n);
  add_forces(net, y.r.data(), f.data(), n);
  const double h = dt / 2 / mass;
  for (long k = 0; k < steps; ++k) {
    std::uint64_t troubles = 0;
    const double *const r = y.r.data(), *const v = y.v.data();
    double *const r1 = next.r.data(), *const v1 = next.v.data(), *const force = f.data();
    for (Index i = 0; i < n; ++i) {
      v1[i] = v[i] + h * force[i];
      r1[i] = r[i] + dt * v1[i];
    }
    f.setZero();
    add_forces(net, r1, f.data(), n);
    for (Index i = 0; i < n; ++i) {
      v1[i] += h * force[i];
      troubles |= trouble(r1[i]) | trouble(v1[i]);
    }
    if (!none(troubles)) break;  // f is then that of a step that wasn't done
    y.r.swap(next.r);
    y.v.swap(next.v);
  }
  return y;
}

}  // namespace small_scenes
