/// @file
/// Which particles sleep: the rule by which each falls asleep and wakes, and what that removed.
///
/// A particle is quiet while |v| < v_s, |ω|R < v_s and |Δr| < v_s Δt between two checks, v_s = SleepOptions::speed. After
/// `steps` quiet steps it sleeps, unless its mean acceleration a over them would make it as fast as v_s within four times
/// as long. Its sleep expires after v_s/|a|, and if it is quiet then as well, after twice that time, and so on. What pushes
/// it meanwhile adds up and fades, p ← (1 − 1/steps) p + Δv, and it wakes where |p| > v_s.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/sleep/sleep_report.hpp"
#include "phistep/state/particles.hpp"

namespace phistep::inline PHISTEP_ABI {

/// One particle, asleep or awake.
struct Sleeper {
  enum class Kind : std::uint8_t {
    held,     ///< by the user
    awake,    ///<
    watched,  ///< asleep, near a particle that is awake: computed, and put back after each step
    deep      ///< asleep, not computed
  };
  Kind kind = Kind::awake;
  bool flagged = false;    ///< its `still` was set by the stepper, not by the user
  std::int32_t naps = 0;   ///< how often its sleep expired
  std::int32_t quiet = 0;  ///< steps
  double impulse = 0;      ///< [force] left out while it is deep
  double since = 0;        ///< [time] by the clock: quiet from then on
  double expires = 0;      ///< [time] by the clock: when its sleep does

  [[nodiscard]] bool is_asleep() const { return kind >= Kind::watched; }
};

/// Those of a state.
template <class S>
struct Sleepers {
  using Scalar = ScalarOf<S>;
  using Vectors = typename S::Vectors;
  using Kind = Sleeper::Kind;
  static constexpr bool spins = S::template has<Spin>;

  SleepOptions options;
  std::vector<Sleeper> all;
  std::vector<std::int64_t> id;
  Vectors rest;      ///< r of those asleep [length]
  Vectors sample;    ///< r at the last check [length]
  Vectors velocity;  ///< v when it became quiet [length/time]
  Vectors push;      ///< p of those watched [length/time]
  SleepReport report;
  std::int64_t free = 0, deep = 0;  ///< particles not held by the user; of them, not computed
  double clock = 0, checked = 0;    ///< [time] of all steps; at the last check
  double review = 0;                ///< [time] by the clock: when the first sleep expires
  double impulse_rate = 0;          ///< [force] Σ of those deep
  std::int64_t since_check = 0;     ///< steps
  bool meddled = false;             ///< the state was changed after the step
  bool changed = false;             ///< since sleepers were last parted into watched and deep

  explicit Sleepers(SleepOptions given) : options{given} {}
  [[nodiscard]] Sleeper& operator[](Index i) { return all[static_cast<std::size_t>(i)]; }

  static void archive_all(auto& ar, auto& sleepers) {
    ar.columns("who", sleepers, "kind", &Sleeper::kind, "flagged", &Sleeper::flagged, "naps", &Sleeper::naps, "quiet",
               &Sleeper::quiet, "impulse", &Sleeper::impulse, "since", &Sleeper::since, "expires", &Sleeper::expires);
    for (const Sleeper& x : sleepers)
      ar.check(x.kind <= Kind::deep && 0 <= x.naps && x.naps <= 30 && 0 <= x.quiet && x.quiet < 1 << 30);
  }

  /// Particles came or went: ids grow from left to right.
  /// @param before  called before any index changes, when there is memory for all
  void match(const S& state, auto&& before) {
    std::vector<Sleeper> now(static_cast<std::size_t>(state.size()));
    Vectors r = state.r, last = state.r, v = state.v, p = Vectors::Zero(S::dimensions, state.size());
    std::vector<std::int64_t> ids = state.id();
    before();
    std::size_t old = 0;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      while (old < id.size() && id[old] < ids[k]) ++old;
      if (old == id.size() || id[old] != ids[k]) continue;
      const auto from = static_cast<Index>(old), to = static_cast<Index>(k);
      now[k] = all[old];
      r.col(to) = rest.col(from), last.col(to) = sample.col(from);
      v.col(to) = velocity.col(from), p.col(to) = push.col(from);
    }
    all = std::move(now), id = std::move(ids);
    rest = std::move(r), sample = std::move(last), velocity = std::move(v), push = std::move(p);
  }
  void count() {
    free = deep = report.asleep = 0;
    impulse_rate = 0;
    review = std::numeric_limits<double>::infinity();
    for (const Sleeper& one : all) {
      free += one.kind != Kind::held;
      deep += one.kind == Kind::deep;
      if (!one.is_asleep()) continue;
      ++report.asleep;
      review = std::min(review, one.expires);
      if (one.kind == Kind::deep) impulse_rate += one.impulse;
    }
  }
  /// A step of dt was done, or left out.
  void pass(Scalar dt) {
    clock += std::abs(dt);
    ++since_check;
    report.skipped += deep;
    report.impulse_not_applied += impulse_rate * static_cast<double>(std::abs(dt));
  }

  void wake(Index i) {
    (*this)[i] = Sleeper{.flagged = (*this)[i].flagged, .since = clock};
    ++report.woken;
    --report.asleep;
    changed = true;
  }
  void wake_all() {
    // None has been quiet for the steps that weren't done.
    since_check = 0;
    checked = clock;
    for (Index i = 0; i < static_cast<Index>(all.size()); ++i)
      if ((*this)[i].is_asleep()) wake(i);
  }

  /// Undoes what the step did to those that are watched, and wakes those that were pushed too far.
  void put_back(S& state) {
    if (report.asleep == deep) return;
    const Scalar fading = 1 - 1 / static_cast<Scalar>(options.steps);
    for (Index i = 0; i < state.size(); ++i) {
      if ((*this)[i].kind != Kind::watched) continue;
      push.col(i) = fading * push.col(i) + state.v.col(i);
      report.impulse_not_applied += static_cast<double>(state.mass()[i] * state.v.col(i).norm());
      // The push is the scene's; the energy is what the step gave it.
      stop(state, i);
      state.r.col(i) = rest.col(i);
      meddled = true;
      if (push.col(i).squaredNorm() > speed_squared()) wake(i);
    }
  }
  /// Wakes those whose sleep has expired, and lets those sleep that have been quiet long enough.
  void check(S& state) {
    const auto elapsed = static_cast<Scalar>(clock - checked);
    for (Index i = 0; i < state.size(); ++i) {
      Sleeper& one = (*this)[i];
      if (one.is_asleep() && clock >= one.expires) {
        const std::int32_t naps = one.naps;
        wake(i);
        one.naps = std::min(naps + 1, 30);
      }
      if (one.kind != Kind::awake) continue;
      const bool quiet = is_quiet(state, i, elapsed);
      one.quiet = quiet ? one.quiet + static_cast<std::int32_t>(since_check) : 0;
      if (one.quiet >= options.steps && may_sleep(state, i)) {
        fall_asleep(state, i);
      } else if (!quiet || one.quiet >= options.steps) {  // what has pushed it is seen over one such time
        one.quiet = 0;
        one.since = clock;
        velocity.col(i) = state.v.col(i);
      }
      sample.col(i) = state.r.col(i);
    }
    since_check = 0;
    checked = clock;
  }

 private:
  [[nodiscard]] Scalar speed_squared() const {
    return static_cast<Scalar>(options.speed) * static_cast<Scalar>(options.speed);
  }
  [[nodiscard]] bool is_quiet(const S& state, Index i, Scalar elapsed) const {
    const Scalar limit = speed_squared();
    bool quiet = state.v.col(i).squaredNorm() < limit &&
                 (state.r.col(i) - sample.col(i)).squaredNorm() < limit * elapsed * elapsed;
    if constexpr (spins) {
      const Scalar R = state.radius()[i];
      quiet = quiet && R * R * state.omega.col(i).squaredNorm() < limit;
    }
    return quiet;
  }
  /// What has been pushing it, on the mean, goes on unseen until that would have made it as fast as `speed`. Where that is
  /// soon, it is not at rest.
  [[nodiscard]] bool may_sleep(const S& state, Index i) {
    Sleeper& one = (*this)[i];
    const auto seen_for = static_cast<Scalar>(clock - one.since);
    const Scalar acceleration = (state.v.col(i) - velocity.col(i)).norm() / seen_for;
    const Scalar lasts = static_cast<Scalar>(options.speed) / acceleration;
    one.impulse = static_cast<double>(state.mass()[i] * acceleration);
    // Many at once: each time that others are computed, neighbours are sought anew.
    const double round = std::ldexp(1.0, std::ilogb(64 * static_cast<double>(seen_for)));
    one.expires = round * std::ceil((clock + std::ldexp(static_cast<double>(lasts), one.naps)) / round);
    return lasts > 4 * seen_for;
  }
  void fall_asleep(S& state, Index i) {
    (*this)[i].kind = Kind::watched;
    stop(state, i);
    rest.col(i) = state.r.col(i);
    push.col(i).setZero();
    ++report.fell_asleep;
    ++report.asleep;
    meddled = changed = true;
  }
  void stop(S& state, Index i) {
    Scalar twice = state.mass()[i] * state.v.col(i).squaredNorm();
    state.v.col(i).setZero();
    if constexpr (spins) {
      twice += state.body().inertia(i) * state.omega.col(i).squaredNorm();
      state.omega.col(i).setZero();
    }
    report.energy_removed += static_cast<double>(twice) / 2;
  }
};

}  // namespace phistep::inline PHISTEP_ABI
