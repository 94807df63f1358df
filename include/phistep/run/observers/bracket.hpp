/// @file
/// A bracket of a root of g(t) is closed by ITP (Oliveira, Takahashi, ACM Trans. Math. Softw. 47 (2021) 5): superlinear on
/// smooth g, and on no g more than two evaluations behind bisection.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Scalar>
struct Sample {
  Scalar t;  ///< [time]
  Scalar g;
};

/// [time] Nearer than this, two times are one: 16 roundings.
template <class Scalar>
[[nodiscard]] Scalar time_resolution(Scalar a, Scalar b) {
  return 8 * std::numeric_limits<Scalar>::epsilon() * std::max(std::abs(a), std::abs(b));
}
/// [time] How long after a root at t0 a step of length dt first evaluates g.
template <class Scalar>
[[nodiscard]] Scalar first_probe(Scalar t0, Scalar dt) {
  constexpr Scalar epsilon = std::numeric_limits<Scalar>::epsilon();
  return 2 * std::max(time_resolution(t0, t0), epsilon * epsilon * std::abs(dt));
}
/// Whether a step of length dt from a root at t0 is too short for g to be probed inside of it.
template <class Scalar>
[[nodiscard]] bool is_short(Scalar t0, Scalar dt) {
  return !(std::abs(dt) >= 64 * first_probe(t0, dt));
}
/// Whether a comes before b where time goes as dt does.
template <class Scalar>
[[nodiscard]] bool is_before(Scalar a, Scalar b, Scalar dt) {
  return dt > 0 ? a < b : a > b;
}
template <class Scalar>
[[nodiscard]] int sign_of(Scalar g) {
  return (g > 0) - (g < 0);
}

/// Closes the bracket a, b of opposite signs in place, by evaluations f(t), until it is no wider than `least` or the
/// resolution of time. Both become the root where f meets zero, or the time where f is not finite.
template <class Scalar, class F>
void close_bracket(Sample<Scalar>& a, Sample<Scalar>& b, Scalar least, F&& f) {
  const Scalar whole = std::abs(b.t - a.t);
  Scalar bisected = whole;  // the width after as many bisections, times 2
  for (int n = 0; n < 100; ++n, bisected /= 2) {
    const Scalar width = b.t - a.t, tolerance = std::max(least, time_resolution(a.t, b.t));
    if (std::abs(width) <= tolerance) return;
    const Scalar to_middle = width / 2, false_position = width * (a.g / (a.g - b.g));
    // Truncated towards the middle, so that both ends move …
    const Scalar shift = std::max(std::abs(width) * (std::abs(width) / whole) / 5, tolerance / 2);
    const Scalar left = to_middle - false_position;
    Scalar off_middle = std::abs(left) > shift ? left - std::copysign(shift, left) : Scalar{0};
    // … and projected to where bisection can still catch up.
    const Scalar reach = std::max(bisected - std::abs(to_middle), Scalar{0});
    if (!(std::abs(off_middle) <= reach)) off_middle = std::copysign(reach, left);
    Scalar t = a.t + (to_middle - off_middle);
    if (t == a.t || t == b.t) t = a.t + to_middle;
    if (t == a.t || t == b.t) return;
    const Sample<Scalar> now{t, f(t)};
    if (!std::isfinite(now.g) || now.g == 0) {
      a = b = now;
      return;
    }
    ((now.g > 0) == (a.g > 0) ? a : b) = now;
  }
}

}}  // namespace phistep::PHISTEP_ABI
