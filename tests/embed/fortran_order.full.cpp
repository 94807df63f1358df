// A code with Fortran's x(3,n), kept as double*: x[3 i + d]. `places(x, n)`, which would be n numbers, is refused
// (tests/compile/places_fortran.cpp); `places<3>(x, n)` moves all.
#include <phistep/in_place.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "support/catch.hpp"

namespace {
using phistep::Index;

/// Twelve chains of eight beads on springs fall on a soft floor, with Lennard-Jones forces between all pairs.
struct Code {
  static constexpr int n = 96;
  std::vector<double> x_ = std::vector<double>(3 * n), v_ = x_, f_ = x_, m_ = std::vector<double>(n);
  double *x = x_.data(), *v = v_.data(), *f = f_.data(), *m = m_.data();
  double potential = 0;

  Code() {
    for (int i = 0; i < n; ++i) {
      const int chain = i / 8, bead = i % 8;
      x[3 * i] = 1.5 * (chain % 4) + 0.01 * std::sin(3.0 * i);
      x[3 * i + 1] = 1.5 * (chain / 4) + 0.01 * std::cos(5.0 * i);
      x[3 * i + 2] = 1 + 1.02 * bead;
      v[3 * i] = 0.1 * std::sin(1.0 * i), v[3 * i + 1] = 0.1 * std::cos(2.0 * i);
      m[i] = bead % 2 == 0 ? 1 : 2;
    }
  }
  Code(const Code&) = delete;
  Code& operator=(const Code&) = delete;

  void forces() {
    potential = 0;
    for (int k = 0; k < 3 * n; ++k) f[k] = 0;
    for (int i = 0; i < n; ++i) {
      if (i % 8 > 0) spring(i - 1, i);
      for (int j = 0; j < i; ++j) pair(i, j);
      const double z = x[3 * i + 2];
      f[3 * i + 2] -= m[i];
      potential += m[i] * z;
      if (z < 0) f[3 * i + 2] -= 200 * z, potential += 100 * z * z;
    }
  }
  [[nodiscard]] double energy() const {
    double sum = potential;
    for (int k = 0; k < 3 * n; ++k) sum += 0.5 * m[k / 3] * v[k] * v[k];
    return sum;
  }

 private:
  void act(int i, int j, double by) {
    for (int d = 0; d < 3; ++d) {
      const double force = by * (x[3 * i + d] - x[3 * j + d]);
      f[3 * i + d] += force, f[3 * j + d] -= force;
    }
  }
  [[nodiscard]] double square(int i, int j) const {
    double sum = 0;
    for (int d = 0; d < 3; ++d) sum += (x[3 * i + d] - x[3 * j + d]) * (x[3 * i + d] - x[3 * j + d]);
    return sum;
  }
  void spring(int i, int j) {
    const double r = std::sqrt(square(i, j));
    act(i, j, -500 * (r - 1) / r);
    potential += 250 * (r - 1) * (r - 1);
  }
  void pair(int i, int j) {
    const double r2 = square(i, j);
    if (r2 > 2.5 * 2.5) return;
    const double q = std::min(std::pow(0.81 / r2, 3), 40.0);
    act(i, j, 4.8 * q * (2 * q - 1) / r2);
    potential += 0.8 * q * (q - 1);
  }
};

constexpr int steps = 2000;
constexpr double dt = 0.002, right_energy = 665.8, tolerated = 0.2;  // Verlet's energy swings by some tenths

/// The energy at the end by velocity Verlet written out.
double by_hand() {
  Code code;
  code.forces();
  for (int s = 0; s < steps; ++s) {
    for (int k = 0; k < 3 * Code::n; ++k) {
      code.v[k] += 0.5 * dt / code.m[k / 3] * code.f[k];
      code.x[k] += dt * code.v[k];
    }
    code.forces();
    for (int k = 0; k < 3 * Code::n; ++k) code.v[k] += 0.5 * dt / code.m[k / 3] * code.f[k];
  }
  return code.energy();
}
/// The same by the library. None: a step is refused.
std::optional<double> by_library(Code& code, auto&& places) {
  phistep::MotionInPlace state{places(code.x), places(code.v), places(code.f)};
  phistep::PhiStepper stepper{state, state.force_of_r([&code] { code.forces(); }), phistep::velocity_verlet,
                              phistep::mass(phistep::places(code.m, Index{Code::n}))};
  for (int s = 0; s < steps; ++s)
    if (!stepper.step(state, s * dt, dt)) return std::nullopt;
  return code.energy();
}
}  // namespace

TEST_CASE("in place: x(3,n) as three adjacent numbers each", "[embed]") {
  CHECK(std::abs(by_hand() - right_energy) <= tolerated);
  Code code;
  const auto energy = by_library(code, [](double* x) { return phistep::places<3>(x, Index{Code::n}); });
  REQUIRE(energy);
  CHECK(std::abs(*energy - right_energy) <= tolerated);
}
