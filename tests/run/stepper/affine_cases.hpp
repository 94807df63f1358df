#pragma once

// What the quick, the full and the long half of run/stepper/affine share.
#include <phistep/phistep.hpp>

#include <algorithm>

#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;

namespace affine_cases {

/// Of 31 steps, 1, 2, 3, 4, 6, 8, 12, 16 and 24 look at their residual: one force call each.
inline constexpr int steps = 31, looks = 9;

inline void check_exact(const Statistics& s, int force_calls) {
  CHECK(s.factorizations == 1);
  CHECK(s.jacobians == 1);
  CHECK(s.solves == steps);
  CHECK(s.iterations == 0);
  CHECK(s.force_calls == force_calls);
}

/// f = K r + C v, promised to be affine, or not.
template <class Matrix, class V>
void check_as_newton(const Matrix& K, const Matrix& C, const Motion<V>& start) {
  const auto promised = linear(K, C);
  const auto unpromised = [=](const V& r, const V& v) -> V { return K * r + C * v; };
  for (const double phi : {0.25, 0.5, 0.8, 1.0})
    for (const double dt : {1e-6, 1e-3, 0.1, 10.0}) {
      if (phi < 0.5 && dt > 1e-3) continue;  // unstable there
      Motion<V> one = start, other = one;
      PhiStepper once{one, promised, phistep::phi(phi), mass(2.0)};
      PhiStepper iterated{other, unpromised, phistep::phi(phi), mass(2.0)};
      for (int n = 0; n < 20; ++n) {
        problems::step(once, one, n * dt, dt);
        problems::step(iterated, other, n * dt, dt);
        // Rounding in Ψ, seen through W⁻¹, is some units in the last place of r and of r/Δt.
        const double r = other.r.norm() + dt * other.v.norm();
        CAPTURE(phi, dt, n);
        REQUIRE((one.r - other.r).norm() <= 1e-12 * std::max(r, 1e-3));
        REQUIRE((one.v - other.v).norm() <= 1e-12 * std::max({r / dt, other.v.norm(), 1e-3}));
        one = other;
      }
    }
}

/// The force is no longer affine once `on`.
template <class V>
void check_change_found(Motion<V>& y, const auto& force, bool& on) {
  PhiStepper stepper{y, force, midpoint};
  for (int n = 0; n < 6; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  on = true;
  Outcome outcome = Outcome::success;
  int n = 6;
  Motion<V> last = y;
  for (; n < 8 && outcome == Outcome::success; ++n) {
    last = y;
    outcome = stepper.step(y, n, 0.1).outcome();
  }
  CHECK(outcome == Outcome::not_affine);
  CHECK(n == 8);
  CHECK((y.r.array() == last.r.array()).all());
}

}  // namespace affine_cases
