#include "hand.hpp"

#include <bit>
#include <cmath>
#include <cstdint>

#if defined(__SSE2__) || defined(_M_X64)
#include <emmintrin.h>
#define OVERHEAD_STREAMS 1
#else
#define OVERHEAD_STREAMS 0
#endif

#if defined(_MSC_VER)
#define OVERHEAD_RESTRICT __restrict
#else
#define OVERHEAD_RESTRICT __restrict__
#endif

namespace overhead {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;
using In = const double* OVERHEAD_RESTRICT;
using Out = double* OVERHEAD_RESTRICT;

/// ±0 for a finite x, else a NaN: its bits, because an OR over them vectorizes and a floating-point sum doesn't.
std::uint64_t trouble(double x) { return std::bit_cast<std::uint64_t>(x - x); }
bool none(std::uint64_t troubles) { return troubles << 1 == 0; }

bool commit(bool finite, VectorXd& r, VectorXd& v, Beside& next) {
  if (!finite) return false;
  r.swap(next.r);
  v.swap(next.v);
  return true;
}

/// Where a force call would stand: the compiler may not fuse the passes around it.
void force_call() {
#if defined(__GNUC__)
  asm volatile("" ::: "memory");
#endif
}

bool finite(const Vector3d& x) { return none(trouble(x[0]) | trouble(x[1]) | trouble(x[2])); }

#if OVERHEAD_STREAMS
__m128d trouble(__m128d x) { return _mm_sub_pd(x, x); }
bool none(__m128d troubles) {
  double lanes[2];
  _mm_storeu_pd(lanes, troubles);
  return lanes[0] == 0 && lanes[1] == 0;  // ±0 or NaN
}
/// Eigen aligns what it owns to 16 bytes unless it is told not to.
bool streams(const Beside& next) {
  return reinterpret_cast<std::uintptr_t>(next.r.data()) % 16 == 0 &&
         reinterpret_cast<std::uintptr_t>(next.v.data()) % 16 == 0;
}
#endif

Vector3d lorenz(const Vector3d& y) {
  return {10.0 * (y[1] - y[0]), 28.0 * y[0] - y[1] - y[0] * y[2], y[0] * y[1] - 8.0 / 3.0 * y[2]};
}
Vector3d spring(const Vector3d& r) { return -r; }

Particle spring_euler(const Particle& y, double dt) { return {y.r + dt * y.v, y.v + dt * spring(y.r)}; }
Particle spring_verlet(const Particle& y, double dt) {
  const Vector3d half = y.v + dt / 2 * spring(y.r);
  const Vector3d r = y.r + dt * half;
  return {r, half + dt / 2 * spring(r)};
}

template <class State, class Step>
State run(State y, long steps, Step step) {
  for (long n = 0; n < steps; ++n) y = step(y);
  return y;
}
template <class Step>
Particle run_guarded(Particle y, long steps, Step step) {
  for (long n = 0; n < steps; ++n) {
    const Particle next = step(y);
    if (!(finite(next.r) && finite(next.v))) break;
    y = next;
  }
  return y;
}

}  // namespace

void hand_euler(VectorXd& r, VectorXd& v, const VectorXd& f, double mass, double dt) {
  const Out x = r.data(), u = v.data();
  const In force = f.data();
  const double a = dt / mass;
  for (Index i = 0, n = r.size(); i < n; ++i) {
    x[i] += dt * u[i];
    u[i] += a * force[i];
  }
}

void eigen_euler(VectorXd& r, VectorXd& v, const VectorXd& f, double mass, double dt) {
  r += dt * v;
  v += dt / mass * f;
}

bool hand_euler_guarded(VectorXd& r, VectorXd& v, const VectorXd& f, double mass, double dt, Beside& next) {
  const In x = r.data(), u = v.data(), force = f.data();
  const Out x1 = next.r.data(), u1 = next.v.data();
  const double a = dt / mass;
  std::uint64_t troubles = 0;
  for (Index i = 0, n = r.size(); i < n; ++i) {
    const double xi = x[i] + dt * u[i], ui = u[i] + a * force[i];
    x1[i] = xi;
    u1[i] = ui;
    troubles |= trouble(xi) | trouble(ui);
  }
  return commit(none(troubles), r, v, next);
}

bool hand_euler_guarded_streaming(VectorXd& r, VectorXd& v, const VectorXd& f, double mass, double dt, Beside& next) {
#if OVERHEAD_STREAMS
  if (!streams(next)) return hand_euler_guarded(r, v, f, mass, dt, next);
  const double *const x = r.data(), *const u = v.data(), *const force = f.data();
  double *const x1 = next.r.data(), *const u1 = next.v.data();
  const double a = dt / mass;
  const __m128d aa = _mm_set1_pd(a), tt = _mm_set1_pd(dt);
  __m128d troubles = _mm_setzero_pd();
  const Index n = r.size(), lines = n / 8 * 8;
  for (Index line = 0; line < lines; line += 8)  // whole cache lines, so that the stores combine
    for (Index i = line; i < line + 8; i += 2) {
      const __m128d ui = _mm_loadu_pd(u + i);
      const __m128d xn = _mm_add_pd(_mm_loadu_pd(x + i), _mm_mul_pd(tt, ui));
      const __m128d un = _mm_add_pd(ui, _mm_mul_pd(aa, _mm_loadu_pd(force + i)));
      _mm_stream_pd(x1 + i, xn);
      _mm_stream_pd(u1 + i, un);
      troubles = _mm_or_pd(troubles, _mm_or_pd(trouble(xn), trouble(un)));
    }
  _mm_sfence();
  std::uint64_t rest = 0;
  for (Index i = lines; i < n; ++i) {
    x1[i] = x[i] + dt * u[i];
    u1[i] = u[i] + a * force[i];
    rest |= trouble(x1[i]) | trouble(u1[i]);
  }
  return commit(none(troubles) && none(rest), r, v, next);
#else
  return hand_euler_guarded(r, v, f, mass, dt, next);
#endif
}

void hand_verlet(VectorXd& r, VectorXd& v, const VectorXd& f, double mass, double dt) {
  const Out x = r.data(), u = v.data();
  const In force = f.data();
  const double a = dt / 2 / mass;
  const Index n = r.size();
  for (Index i = 0; i < n; ++i) {
    u[i] += a * force[i];
    x[i] += dt * u[i];
  }
  force_call();
  for (Index i = 0; i < n; ++i) u[i] += a * force[i];
}

void eigen_verlet(VectorXd& r, VectorXd& v, const VectorXd& f, double mass, double dt) {
  const double a = dt / 2 / mass;
  v += a * f;
  r += dt * v;
  force_call();
  v += a * f;
}

bool hand_verlet_guarded(VectorXd& r, VectorXd& v, const VectorXd& f, double mass, double dt, Beside& next) {
  const In x = r.data(), u = v.data(), force = f.data();
  const Out x1 = next.r.data(), u1 = next.v.data();
  const double a = dt / 2 / mass;
  const Index n = r.size();
  std::uint64_t troubles = 0;
  for (Index i = 0; i < n; ++i) {  // v stays: only r⁺ is written before the second force is known
    const double xi = x[i] + dt * (u[i] + a * force[i]);
    x1[i] = xi;
    troubles |= trouble(xi);
  }
  force_call();
  for (Index i = 0; i < n; ++i) {
    const double ui = (u[i] + a * force[i]) + a * force[i];
    u1[i] = ui;
    troubles |= trouble(ui);
  }
  return commit(none(troubles), r, v, next);
}

bool hand_verlet_guarded_streaming(VectorXd& r, VectorXd& v, const VectorXd& f, double mass, double dt, Beside& next) {
#if OVERHEAD_STREAMS
  if (!streams(next)) return hand_verlet_guarded(r, v, f, mass, dt, next);
  const double *const x = r.data(), *const u = v.data(), *const force = f.data();
  double *const x1 = next.r.data(), *const u1 = next.v.data();
  const double a = dt / 2 / mass;
  const __m128d aa = _mm_set1_pd(a), tt = _mm_set1_pd(dt);
  __m128d troubles = _mm_setzero_pd();
  std::uint64_t rest = 0;
  const Index n = r.size(), lines = n / 8 * 8;
  for (Index line = 0; line < lines; line += 8)
    for (Index i = line; i < line + 8; i += 2) {
      const __m128d half = _mm_add_pd(_mm_loadu_pd(u + i), _mm_mul_pd(aa, _mm_loadu_pd(force + i)));
      const __m128d xn = _mm_add_pd(_mm_loadu_pd(x + i), _mm_mul_pd(tt, half));
      _mm_stream_pd(x1 + i, xn);
      troubles = _mm_or_pd(troubles, trouble(xn));
    }
  _mm_sfence();
  for (Index i = lines; i < n; ++i) {
    x1[i] = x[i] + dt * (u[i] + a * force[i]);
    rest |= trouble(x1[i]);
  }
  force_call();
  for (Index line = 0; line < lines; line += 8)
    for (Index i = line; i < line + 8; i += 2) {
      const __m128d kick = _mm_mul_pd(aa, _mm_loadu_pd(force + i));
      const __m128d un = _mm_add_pd(_mm_add_pd(_mm_loadu_pd(u + i), kick), kick);
      _mm_stream_pd(u1 + i, un);
      troubles = _mm_or_pd(troubles, trouble(un));
    }
  _mm_sfence();
  for (Index i = lines; i < n; ++i) {
    u1[i] = (u[i] + a * force[i]) + a * force[i];
    rest |= trouble(u1[i]);
  }
  return commit(none(troubles) && none(rest), r, v, next);
#else
  return hand_verlet_guarded(r, v, f, mass, dt, next);
#endif
}

void hand_chain_force(const VectorXd& r, VectorXd& f, const Chain& chain) {
  const In x = r.data();
  const Out force = f.data();
  const Index n = r.size();
  for (Index i = 0; i < n; i += 3) force[i] = chain.pull, force[i + 1] = 0, force[i + 2] = 0;
  for (const Chain::Tie& tie : chain.ties) {
    const Index i = 3 * tie.i, j = 3 * tie.j;
    const double d[] = {x[j] - x[i], x[j + 1] - x[i + 1], x[j + 2] - x[i + 2]};
    const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const double tension = tie.stiffness * (length - tie.length) / length;
    for (int a = 0; a < 3; ++a) {
      force[i + a] += tension * d[a];
      force[j + a] -= tension * d[a];
    }
  }
}
void hand_chain_euler(VectorXd& r, VectorXd& v, VectorXd& f, const Chain& chain, double mass, double dt) {
  hand_chain_force(r, f, chain);
  hand_euler(r, v, f, mass, dt);
}
void hand_chain_verlet(VectorXd& r, VectorXd& v, VectorXd& f, const Chain& chain, double mass, double dt) {
  const Out x = r.data(), u = v.data();
  const Index n = r.size();
  const double a = dt / 2 / mass;
  for (Index i = 0; i < n; ++i) {
    u[i] += a * f.data()[i];
    x[i] += dt * u[i];
  }
  hand_chain_force(r, f, chain);
  for (Index i = 0; i < n; ++i) u[i] += a * f.data()[i];
}

void hand_bodies_euler(std::vector<Body>& bodies, double dt) {
  for (Body& b : bodies) {
    const double a = dt / b.mass;
    for (int k = 0; k < 3; ++k) {
      b.r[k] += dt * b.v[k];
      b.v[k] += a * b.f[k];
    }
  }
}
void hand_bodies_verlet(std::vector<Body>& bodies, double dt) {
  for (Body& b : bodies) {
    const double a = dt / 2 / b.mass;
    for (int k = 0; k < 3; ++k) {
      b.v[k] += a * b.f[k];
      b.r[k] += dt * b.v[k];
    }
  }
  force_call();
  for (Body& b : bodies) {
    const double a = dt / 2 / b.mass;
    for (int k = 0; k < 3; ++k) b.v[k] += a * b.f[k];
  }
}

Vector3d hand_lorenz_doubles(Vector3d start, double dt, long steps) {
  double x = start[0], y = start[1], z = start[2];
  for (long n = 0; n < steps; ++n) {
    const double dx = 10.0 * (y - x), dy = 28.0 * x - y - x * z, dz = x * y - 8.0 / 3.0 * z;
    x += dt * dx;
    y += dt * dy;
    z += dt * dz;
  }
  return {x, y, z};
}

Vector3d hand_lorenz_eigen(Vector3d y, double dt, long steps) {
  return run(y, steps, [dt](const Vector3d& x) -> Vector3d { return x + dt * lorenz(x); });
}

Vector3d hand_lorenz_eigen_guarded(Vector3d y, double dt, long steps) {
  for (long n = 0; n < steps; ++n) {
    const Vector3d next = y + dt * lorenz(y);
    if (!finite(next)) break;
    y = next;
  }
  return y;
}

Particle hand_spring_euler(Particle y, double dt, long steps) {
  return run(y, steps, [dt](const Particle& x) { return spring_euler(x, dt); });
}
Particle hand_spring_euler_guarded(Particle y, double dt, long steps) {
  return run_guarded(y, steps, [dt](const Particle& x) { return spring_euler(x, dt); });
}
Particle hand_spring_verlet(Particle y, double dt, long steps) {
  return run(y, steps, [dt](const Particle& x) { return spring_verlet(x, dt); });
}
Particle hand_spring_verlet_guarded(Particle y, double dt, long steps) {
  return run_guarded(y, steps, [dt](const Particle& x) { return spring_verlet(x, dt); });
}

}  // namespace overhead
