/// @file
/// Which particles sleep: the rule by which each falls asleep and wakes, and what that removed.
///
/// A particle is quiet while |v| < v_s, |ω − ω₀|R < v_s and |Δr| < v_s Δt between two checks, v_s = SleepOptions::speed, ω₀ its
/// spin when it became quiet: one that spins on the spot, which no friction stops, moves nobody. After `steps` quiet steps
/// it is watched, until it is faster. Who is watched, and touches nobody that is awake, falls asleep, unless its mean
/// acceleration a over at least `steps` steps (that of its surface, if this is larger) would make it as fast as v_s within
/// four times as long. Asleep, it keeps its spin. Its sleep expires after v_s/|a|, and if it is quiet then as well, after
/// twice that time, and so on; it is watched again. A sleeper is watched again, too, as soon as somebody awake touches it, or
/// a watched one that touches it has moved by v_s times the time between two checks.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/state/particle_fingerprint.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/bodies/particles.hpp"
#include "phistep/particles/sleep/sleep_report.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// What is known of one particle that may sleep.

/// One particle, asleep or awake.
struct Sleeper {
  enum class Kind : std::uint8_t {
    held,     ///< by the user
    awake,    ///<
    watched,  ///< slow: computed as any other
    asleep    ///< not computed
  };
  Kind kind = Kind::awake;
  bool moves = false;            ///< held, with a velocity or a spin
  std::uint64_t properties = 0;  ///< fingerprint of its mass, radius …
  std::uint64_t seen = 0;        ///< … and of its numbers in the state: asleep, or held at rest
  std::int32_t naps = 0;         ///< how often its sleep expired
  std::int32_t quiet = 0;        ///< steps
  double impulse = 0;            ///< [force] left out while it sleeps
  double since = 0;              ///< [time] by the clock: quiet from then on
  double expires = 0;            ///< [time] by the clock: when its sleep does

  [[nodiscard]] bool is_asleep() const { return kind == Kind::asleep; }
  [[nodiscard]] bool is_computed() const { return kind == Kind::awake || kind == Kind::watched; }
  /// It stays as it is, so that a change of it is an edit.
  [[nodiscard]] bool rests() const { return kind == Kind::asleep || (kind == Kind::held && !moves); }
  /// Who touches it can't sleep.
  [[nodiscard]] bool disturbs() const { return kind == Kind::awake || (kind == Kind::held && moves); }
};

/// Those of a state.
template <class S>
struct Sleepers {
  using Scalar = ScalarOf<S>;
  using Vectors = typename S::Vectors;
  using Kind = Sleeper::Kind;
  static constexpr bool spins = S::template has<Spin>;
  static auto& spin_of(auto& state) {
    if constexpr (spins) return state.omega;
    else return state.v;  // of no interest
  }
  using Spins = std::remove_cvref_t<decltype(spin_of(std::declval<S&>()))>;

  SleepOptions options;
  std::vector<Sleeper> all;
  std::vector<std::int64_t> id;
  std::vector<std::uint8_t> is_computed;  ///< of each, whether it is awake or watched
  Vectors rest;      ///< r of those asleep, held and watched, from where on the last count as moved [length]
  Vectors sample;    ///< r at the last check [length]
  Vectors velocity;  ///< v when it became quiet [length/time]
  Spins spin;        ///< ω then [1/time]
  SleepReport report;
  std::int64_t free = 0;          ///< particles not held by the user
  double clock = 0, checked = 0;  ///< [time] of all steps; at the last check
  double review = 0;              ///< [time] by the clock: no sleep expires before
  double impulse_rate = 0;        ///< [force] Σ of those asleep
  std::uint64_t seen = 0;         ///< Σ of those that rest
  std::int64_t since_check = 0;   ///< steps
  std::int64_t sets = 0;          ///< active sets made since the last check
  double unrest = 0;              ///< recent changes of the active set per step, 0 … 1; 3 after a check that woke all
  bool meddled = false;           ///< the state was changed after the step
  bool changed = false;           ///< somebody's kind, since lists were made of them
  explicit Sleepers(SleepOptions given) : options{given} {}
  [[nodiscard]] Sleeper& operator[](Index i) { return all[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Sleeper& operator[](Index i) const { return all[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Index size() const { return static_cast<Index>(all.size()); }

  static void archive_all(auto& ar, auto& sleepers) {
    ar.columns("who", sleepers, "kind", &Sleeper::kind, "moves", &Sleeper::moves, "properties", &Sleeper::properties,
               "seen", &Sleeper::seen, "naps", &Sleeper::naps, "quiet", &Sleeper::quiet, "impulse", &Sleeper::impulse,
               "since", &Sleeper::since, "expires", &Sleeper::expires);
    for (const Sleeper& x : sleepers)
      ar.check(x.kind <= Kind::asleep && 0 <= x.naps && x.naps <= 30 && 0 <= x.quiet && x.quiet < 1 << 30);
  }

  /// Particles came or went: ids grow from left to right.
  /// @param before  called before any index changes, when there is memory for all
  void match(const S& state, auto&& before) {
    std::vector<Sleeper> now(static_cast<std::size_t>(state.size()));
    Vectors r = state.r, last = state.r, v = state.v;
    Spins turns = spin_of(state);
    std::vector<std::int64_t> ids = state.id();
    before();
    std::size_t old = 0;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      while (old < id.size() && id[old] < ids[k]) ++old;
      if (old == id.size() || id[old] != ids[k]) continue;
      const auto from = static_cast<Index>(old), to = static_cast<Index>(k);
      now[k] = all[old];
      // The fingerprint of one that was edited, too, stays another one.
      if (now[k].seen == ParticleFingerprint<S>::of(state, to, from))
        now[k].seen = ParticleFingerprint<S>::of(state, to);
      r.col(to) = rest.col(from), last.col(to) = sample.col(from), v.col(to) = velocity.col(from);
      turns.col(to) = spin.col(from);
    }
    all = std::move(now), id = std::move(ids);
    rest = std::move(r), sample = std::move(last), velocity = std::move(v), spin = std::move(turns);
  }
  void find_computed() {
    is_computed.resize(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) is_computed[i] = all[i].is_computed() ? 1 : 0;
  }
  void count() {
    find_computed();
    free = report.asleep = 0;
    impulse_rate = 0;
    seen = 0;
    review = std::numeric_limits<double>::infinity();
    for (const Sleeper& one : all) {
      free += one.kind != Kind::held;
      if (one.rests()) seen += one.seen;
      if (!one.is_asleep()) continue;
      ++report.asleep;
      review = std::min(review, one.expires);
      impulse_rate += one.impulse;
    }
  }
  /// A step of dt was done, or left out.
  void pass(Scalar dt) {
    clock += std::abs(dt);
    ++since_check;
    report.skipped += report.asleep;
    report.impulse_not_applied += impulse_rate * static_cast<double>(std::abs(dt));
  }

  /// A sleeper is computed again.
  void wake(Index i, Kind kind) {
    Sleeper& one = (*this)[i];
    seen -= one.seen;
    ++report.woken;
    --report.asleep;
    impulse_rate = report.asleep == 0 ? 0 : impulse_rate - one.impulse;
    one = Sleeper{.kind = kind, .properties = one.properties, .naps = one.naps, .since = clock};
    is_computed[static_cast<std::size_t>(i)] = 1;
    velocity.col(i).setZero();
    sample.col(i) = rest.col(i);
    changed = true;
  }
  void wake_all() {
    // None has been quiet for the steps that weren't done.
    since_check = 0;
    checked = clock;
    for (Index i = 0; i < size(); ++i)
      if ((*this)[i].is_asleep()) wake(i, Kind::awake), (*this)[i].naps = 0;
  }
  [[nodiscard]] static bool moves(const S& state, Index i) {
    return (state.v.col(i).array() != 0).any() || (spin_of(state).col(i).array() != 0).any();
  }
  /// Who is watched is awake from now on where it is fast.
  [[nodiscard]] bool is_fast(const S& state, Index i) const { return !is_slow(state, i); }
  /// By how far one may move beside a sleeper, squared [length²].
  [[nodiscard]] Scalar far_squared(Scalar dt) const {
    const Scalar limit = static_cast<Scalar>(options.speed) * std::abs(dt) * static_cast<Scalar>(options.every);
    return limit * limit;
  }
  [[nodiscard]] bool has_moved(const S& state, Index i, Scalar dt) const {
    return !((state.r.col(i) - rest.col(i)).squaredNorm() < far_squared(dt));
  }

  /// Wakes those whose sleep has expired, and looks who of those computed is slow.
  void check(const S& state, const std::vector<std::int32_t>& computed) {
    const auto elapsed = static_cast<Scalar>(clock - checked);
    for (const Index i : computed) {
      Sleeper& one = (*this)[i];
      if (!one.is_computed()) continue;
      const bool quiet =
          is_slow(state, i) && (state.r.col(i) - sample.col(i)).squaredNorm() < speed_squared() * elapsed * elapsed;
      one.quiet = quiet ? one.quiet + static_cast<std::int32_t>(since_check) : 0;
      if (!quiet) {
        changed = changed || one.kind == Kind::watched;
        one.kind = Kind::awake;
        begin(state, i);
      } else if (one.kind == Kind::awake && one.quiet >= options.steps) {
        one.kind = Kind::watched;
        rest.col(i) = state.r.col(i);
        changed = true;
      }
      sample.col(i) = state.r.col(i);
    }
    if (clock >= review) {
      for (Index i = 0; i < size(); ++i)
        if (Sleeper& one = (*this)[i]; one.is_asleep() && clock >= one.expires) {
          wake(i, Kind::watched);
          one.naps = std::min(one.naps + 1, 30);
        }
      count();
    }
    // Remembered for some fifty checks: who has been put to sleep and woken in vain isn't put to sleep again at once.
    unrest = std::max(0.97 * unrest, std::min(1.0, static_cast<double>(sets) / static_cast<double>(since_check)));
    sets = 0;
    since_check = 0;
    checked = clock;
  }
  /// What has been pushing it, on the mean, goes on unseen until that would have made it as fast as `speed`. Where that is
  /// soon, it is not at rest.
  [[nodiscard]] bool may_sleep(const S& state, Index i) {
    Sleeper& one = (*this)[i];
    if (one.kind != Kind::watched || one.quiet < options.steps) return false;
    const auto seen_for = static_cast<Scalar>(clock - one.since);
    Scalar change = (state.v.col(i) - velocity.col(i)).norm();
    if constexpr (spins) change = std::max(change, state.radius()[i] * (state.omega.col(i) - spin.col(i)).norm());
    const Scalar acceleration = change / seen_for, lasts = static_cast<Scalar>(options.speed) / acceleration;
    if (!(lasts > 4 * seen_for)) {  // what pushes it is seen over one such time
      one.quiet = 0;
      begin(state, i);
      return false;
    }
    one.impulse = static_cast<double>(state.mass()[i] * acceleration);
    // Many at once.
    const double round = std::ldexp(1.0, std::ilogb(64 * static_cast<double>(seen_for)));
    one.expires = round * std::ceil((clock + std::ldexp(static_cast<double>(lasts), one.naps)) / round);
    return true;
  }
  void fall_asleep(S& state, Index i) {
    Sleeper& one = (*this)[i];
    one.kind = Kind::asleep;
    is_computed[static_cast<std::size_t>(i)] = 0;
    report.energy_removed += static_cast<double>(state.mass()[i] * state.v.col(i).squaredNorm()) / 2;
    state.v.col(i).setZero();
    rest.col(i) = state.r.col(i);
    spin.col(i) = spin_of(state).col(i);
    one.seen = ParticleFingerprint<S>::of(state, i);
    seen += one.seen;
    review = std::min(review, one.expires);
    impulse_rate += one.impulse;
    ++report.fell_asleep;
    ++report.asleep;
    meddled = changed = true;
  }

 private:
  [[nodiscard]] Scalar speed_squared() const {
    return static_cast<Scalar>(options.speed) * static_cast<Scalar>(options.speed);
  }
  [[nodiscard]] bool is_slow(const S& state, Index i) const {
    bool slow = state.v.col(i).squaredNorm() < speed_squared();
    if constexpr (spins) {
      const Scalar R = state.radius()[i];
      slow = slow && R * R * (state.omega.col(i) - spin.col(i)).squaredNorm() < speed_squared();
    }
    return slow;
  }
  void begin(const S& state, Index i) {
    (*this)[i].since = clock;
    velocity.col(i) = state.v.col(i);
    spin.col(i) = spin_of(state).col(i);
  }
};

}}  // namespace phistep::PHISTEP_ABI
