/// @file
/// A root that was sought on an interpolated g is moved to where g vanishes after a step really done, by secants.
#pragma once

#include <cmath>

#include "phistep/base/version.hpp"
#include "phistep/run/observers/bracket.hpp"
#include "phistep/run/observers/root.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <class Scalar>
struct Refined {
  Scalar t;         ///< [time] of the last step really done
  Scalar g;         ///< after it; not finite where that step failed
  int resteps = 0;  ///< 0 where the root is the end of the step
};

/// Moves an interpolated root to where g vanishes after a step really done. `restep(t)` steps from t0 to t anew and
/// returns g; the last one done is the one that counts. Ends within the resolution of time, beyond the root where secants
/// have not met it in `most` steps.
template <class Scalar, class Restep>
[[nodiscard]] Refined<Scalar> refine(const Root<Scalar>& root, Sample<Scalar> end, Restep&& restep, int most = 6) {
  Refined<Scalar> now{root.t, end.g, 0};
  if (root.t == end.t) return now;
  Sample<Scalar> a = root.before, b = root.after;
  Scalar slope = root.slope;
  const int s = sign_of(a.g);
  for (Sample<Scalar> last{};;) {
    now.g = restep(now.t);
    ++now.resteps;
    if (!std::isfinite(now.g)) return now;
    if (std::abs(now.g) <= std::abs(slope) * root.tolerance) return now;
    (sign_of(now.g) == s ? a : b) = {now.t, now.g};
    if (now.resteps >= most || std::abs(b.t - a.t) <= root.tolerance) break;
    if (now.resteps > 1) slope = (now.g - last.g) / (now.t - last.t);
    Scalar t = now.t - now.g / slope;
    if (!(is_before(a.t, t, b.t - a.t) && is_before(t, b.t, b.t - a.t))) t = a.t + (b.t - a.t) / 2;
    if (t == now.t) return now;
    last = {now.t, now.g};
    now.t = t;
  }
  // What secants don't close, a jump of g above all, is closed as a bracket is.
  close_bracket(a, b, root.tolerance, [&](Scalar t) {
    ++now.resteps;
    return now.g = restep(now.t = t);
  });
  if (now.t == b.t) return now;
  now.t = b.t;
  now.g = restep(b.t);
  ++now.resteps;
  return now;
}

}}  // namespace phistep::PHISTEP_ABI
