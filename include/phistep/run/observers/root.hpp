/// @file
/// The first root of a function g(t) within a step, known by its values alone: what events are made of.
///
///   1. The sign just after t0. Where g(t0) is zero, or what rounding left of a root, g is probed at t0 + δ, t0 + 4δ, …
///      until it has clearly left zero.
///   2. A sign change until t1 holds a root. Without one, g may pass zero and come back: where its slope points towards
///      zero at the start and away from zero at the end, the turning point between them is sought.
///   3. The bracket is closed by ITP (Oliveira, Takahashi, ACM Trans. Math. Softw. 47 (2021) 5): superlinear on smooth g, and on
///      no g more than two evaluations behind bisection.
///   4. That g was interpolated: refine() moves the root to where g vanishes after a step really done, by secants.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
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

/// Moves a and b, where f has opposite signs, towards each other by evaluations f(t), until they are no further apart than `least` or the
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
    // Projected to where bisection can still catch up.
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

/// Which way g passes zero as the run goes. A backward run meets a function that grows with t as a falling one.
enum class Direction : std::int8_t {
  falling = -1,  ///< from plus to minus
  both = 0,      ///< either way
  rising = 1,    ///< from minus to plus
};

/// How g(t0) is to be read.
enum class Standing : std::uint8_t {
  clear,    ///< its sign is right, unless it is zero
  on_root,  ///< the run stands on a root already handled: g(t0) is rounding
  unknown,  ///< one look will tell
};

/// The outcome of a search.
template <class Scalar>
struct Root {
  enum class Kind : std::uint8_t { none, found, not_finite };
  Kind kind = Kind::none;
  Scalar t{};                        ///< [time] the root, or where g is not finite; never t0
  Sample<Scalar> before{}, after{};  ///< g changes sign between, or is zero at the latter
  Scalar slope{};                    ///< dg/dt at the root
  Scalar tolerance{};                ///< [time] to which it is known
  int start_sign = 0;                ///< of g just after t0; 0 where the step doesn't tell
  Scalar start{};                    ///< [time] when it has that sign for the first time
};

/// Seeks the first root between the ends of a step by evaluations value(t).
template <class Scalar, class Value>
class RootSearch {
 public:
  using Kind = typename Root<Scalar>::Kind;

  RootSearch(Sample<Scalar> start, Sample<Scalar> end, Value& value)
      : start_{start}, end_{end}, whole_{end.t - start.t}, value_{value} {}

  /// @param inside   find a turning point, too
  [[nodiscard]] Root<Scalar> run(Standing standing, Direction wanted, bool inside) {
    Root<Scalar> root;
    for (const auto& s : {start_, end_})
      if (!std::isfinite(s.g)) return not_finite(s.t);
    const Sample<Scalar> from = start_of(standing);
    if (failed_) return not_finite(from.t);
    const int s = sign_of(from.g);
    root.start_sign = s;
    root.start = from.t;
    if (s == 0) return root;
    if (reaches_zero(from)) end_.g = 0;
    if (failed_) return not_finite(end_.t);
    const bool differs = sign_of(end_.g) != s;
    if (inside && (!differs || end_.g == 0)) {
      const Sample<Scalar> turn = turning_point(from);
      if (failed_) return not_finite(turn.t);
      if (sign_of(turn.g) == -s) return wants(wanted, -s) ? close(root, from, turn) : close(root, turn, end_);
    }
    return differs && wants(wanted, -s) ? close(root, from, end_) : root;
  }

 private:
  [[nodiscard]] static bool wants(Direction wanted, int going) {
    return wanted == Direction::both || static_cast<int>(wanted) == going;
  }
  [[nodiscard]] static Root<Scalar> not_finite(Scalar t) {
    Root<Scalar> root;
    root.kind = Kind::not_finite;
    root.t = t;
    return root;
  }
  [[nodiscard]] Sample<Scalar> sample(Scalar t) {
    const Sample<Scalar> now{t, value_(t)};
    failed_ = failed_ || !std::isfinite(now.g);
    return now;
  }

  [[nodiscard]] Sample<Scalar> start_of(Standing standing) {
    if (standing == Standing::on_root || start_.g == 0) return departure();
    if (standing == Standing::clear) return start_;
    const Scalar delta = first_probe(start_.t, whole_);
    if (!(delta < std::abs(whole_))) return start_;
    const Sample<Scalar> now = sample(start_.t + std::copysign(delta, whole_));
    if (failed_) return now;
    return std::abs(now.g - start_.g) <= std::abs(start_.g) || jumps_before(now) ? start_ : departure();
  }
  /// Whether g changes its sign from the start to `now` by a jump: no run that ended at the start has seen it.
  [[nodiscard]] bool jumps_before(Sample<Scalar> now) {
    const int s = sign_of(start_.g);
    if (sign_of(now.g) != -s) return false;
    Sample<Scalar> a = start_, b = now;
    for (int n = 0; n < 8 && !failed_; ++n) {
      const Sample<Scalar> middle = sample(a.t + (b.t - a.t) / 2);
      (sign_of(middle.g) == s ? a : b) = middle;
    }
    return std::abs(b.g - a.g) > std::abs(now.g - start_.g) / 2;
  }

  /// Whether the root lies so near behind the end that a run which starts there takes g for a root already handled (the
  /// rule of start_of, backwards): of two runs in a row one finds it. Asks g only where its fall in this step says so.
  [[nodiscard]] bool reaches_zero(Sample<Scalar> from) {
    const Scalar delta = first_probe(end_.t, whole_), g = std::abs(end_.g);
    if (sign_of(end_.g) != sign_of(from.g) || !(delta < std::abs(end_.t - from.t))) return false;
    if (!(g * std::abs(whole_) <= 16 * delta * std::abs(from.g))) return false;
    const Sample<Scalar> before = sample(end_.t - std::copysign(delta, whole_));
    return sign_of(before.g) == sign_of(end_.g) && std::abs(before.g) - g > g;
  }

  /// Where g has clearly left zero: three probes in a row grow, out of what rounding made of those before.
  [[nodiscard]] Sample<Scalar> departure() {
    const Scalar first = first_probe(start_.t, whole_);
    Sample<Scalar> nearest{start_.t, 0}, last = nearest;
    Scalar noise = std::abs(start_.g);
    int grown = 0;
    for (Scalar delta = first; delta < std::abs(whole_); delta *= 4) {
      const Sample<Scalar> now = sample(start_.t + std::copysign(delta, whole_));
      if (failed_) return now;
      if (nearest.g == 0) nearest = now;
      if (now.g != 0 && sign_of(now.g) == sign_of(last.g) && std::abs(now.g) >= Scalar(1.5) * std::abs(last.g)) {
        if (++grown >= 2 && std::abs(now.g) >= 8 * noise) return now;
      } else {
        grown = 0;
        noise = std::max(noise, std::abs(last.g));
      }
      last = now;
    }
    if (!is_short(start_.t, whole_)) return nearest;  // a jump doesn't grow
    // In a step too short for that, its end tells, or that of the next.
    return std::abs(end_.g) >= Scalar(1.5) * std::abs(start_.g) ? end_ : Sample<Scalar>{start_.t, 0};
  }

  /// Some time between `from` and the end where g has the other sign; if there seems to be none, any with the same.
  [[nodiscard]] Sample<Scalar> turning_point(Sample<Scalar> from) {
    const int s = sign_of(from.g);
    const Scalar h = std::copysign(difference(), whole_);
    if (!(4 * std::abs(h) < std::abs(end_.t - from.t))) return from;
    const Sample<Scalar> first = sample(from.t + h);
    if (failed_ || sign_of(first.g) != s || !(std::abs(first.g) < std::abs(from.g))) return first;
    const Sample<Scalar> last = sample(end_.t - h);
    if (failed_ || sign_of(last.g) != s || !(std::abs(last.g) < std::abs(end_.g))) return last;
    Sample<Scalar> falls{from.t + h / 2, std::abs(first.g) - std::abs(from.g)},
        climbs{end_.t - h / 2, std::abs(end_.g) - std::abs(last.g)}, turn = last;
    close_bracket(falls, climbs, 2 * std::abs(h), [&](Scalar t) {
      Scalar slope = 0;
      for (const int side : {-1, 1}) {
        turn = sample(t + static_cast<Scalar>(side) * h / 2);
        if (failed_ || sign_of(turn.g) != s) return Scalar{0};  // enough
        slope += static_cast<Scalar>(side) * std::abs(turn.g);
      }
      return slope;
    });
    return turn;
  }

  [[nodiscard]] Root<Scalar> close(Root<Scalar> root, Sample<Scalar> before, Sample<Scalar> after) {
    Sample<Scalar> a = before, b = after;
    // A bound relative to t is 0 at t = 0; t − t0 has this rounding at least.
    const Scalar least = 2 * std::numeric_limits<Scalar>::epsilon() * std::min(std::abs(start_.t), std::abs(end_.t));
    if (b.g == 0) a = b;
    else close_bracket(a, b, least, [this](Scalar t) { return sample(t).g; });
    if (failed_) return not_finite(a.t);
    root.kind = Kind::found;
    root.t = std::abs(a.g) < std::abs(b.g) && a.t != start_.t ? a.t : b.t;
    root.before = before;
    root.after = after;
    const Scalar h = std::copysign(difference(), whole_);
    const auto inside = [this](Scalar t) {
      return whole_ > 0 ? std::clamp(t, start_.t, end_.t) : std::clamp(t, end_.t, start_.t);
    };
    const Sample<Scalar> earlier = sample(inside(root.t - h)), later = sample(inside(root.t + h));
    if (failed_) return not_finite(root.t);
    root.tolerance = std::max(least, time_resolution(root.t, root.t));
    root.slope = (later.g - earlier.g) / (later.t - earlier.t);
    return root;
  }
  /// [time] For slopes by differences.
  [[nodiscard]] Scalar difference() const {
    return std::max(std::sqrt(std::numeric_limits<Scalar>::epsilon()) * std::abs(whole_),
                    time_resolution(start_.t, end_.t));
  }

  Sample<Scalar> start_, end_;
  Scalar whole_;
  Value& value_;
  bool failed_ = false;
};

/// The first root of g within a step, sought as RootSearch::run says.
template <class Scalar, class Value>
[[nodiscard]] Root<Scalar> first_root(Sample<Scalar> start, Sample<Scalar> end, Value&& value,
                                      Standing standing = Standing::clear, Direction wanted = Direction::both,
                                      bool inside = true) {
  return RootSearch<Scalar, Value>(start, end, value).run(standing, wanted, inside);
}

template <class Scalar>
struct Refined {
  Scalar t;         ///< [time] of the last step really done
  Scalar g;         ///< after it; not finite where that step failed
  int resteps = 0;  ///< steps done anew; 0 where the root is the end of the step
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
