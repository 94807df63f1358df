/// @file
/// Which particles sleep: when each falls asleep and wakes, and what that removed.
///
/// A particle is quiet while |v| < v_s, |ω − ω₀|R < v_s and |Δr| < v_s Δt between two checks. v_s is SleepOptions::speed, ω₀ its
/// spin when it became quiet: one that spins on the spot, which no friction stops, moves no other. After `steps` quiet steps it is
/// watched: computed as before, until it is faster than v_s. A watched particle that touches none that is awake falls asleep, unless
/// its mean acceleration a over at least `steps` steps (that of its surface, if this is larger) would make it as fast as v_s within
/// four times as long. It keeps its spin, but for what rolls with v. It is watched again when |v + a t| would reach v_s, when one
/// that is awake touches it, or when a watched one that touches it has moved farther than at speed v_s from one check to the next.
///
/// A sleep of a time τ leaves out the velocity v, what rolls with it, and the acceleration a. When the particle has been quiet for
/// `steps` steps again, its mean acceleration shows whether a was a push that goes on, as at a turning point or on a gentle slope: then
/// it gets v + aτ. Else a was a trembling that has passed: it sleeps on, twice as long as before.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/particle_fingerprint.hpp"
#include "phistep/particles/bodies/particles.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// When particles fall asleep.
struct SleepOptions {
  double speed = 0;  ///< [length/time] of a particle at rest, and the change that wakes it; 0: none sleeps
  int steps = 100;   ///< for so many steps
  int every = 25;    ///< steps between two checks of which bodies may fall asleep
};

/// What sleep has saved and cost since the stepper was made.
struct SleepReport {
  std::int64_t asleep = 0;         ///< particles now
  std::int64_t fell_asleep = 0;    ///< how often one did
  std::int64_t woken = 0;          ///< how often one was woken
  std::int64_t skipped = 0;        ///< particle-steps that were not computed
  double energy_removed = 0;       ///< kinetic energy taken from sleepers and not given back [energy]
  double impulse_not_applied = 0;  ///< Σ∫|F|dt not given back, F the mean push before a sleep [force·time]

  void archive(auto& ar) {
    ar("asleep", asleep, "fell_asleep", fell_asleep, "woken", woken, "skipped", skipped, "energy_removed",
       energy_removed, "impulse_not_applied", impulse_not_applied);
    for (const std::int64_t count : {asleep, fell_asleep, woken, skipped}) ar.check(can_be_count(count));
  }

  friend auto& operator<<(TextStream auto& out, const SleepReport& r) {
    return out << "  asleep              " << r.asleep << "  (fell asleep " << r.fell_asleep << " times, woken "
               << r.woken << ")\n  skipped             " << r.skipped << " particle steps\n  energy removed      "
               << r.energy_removed << "\n  impulse not applied " << r.impulse_not_applied << '\n';
  }
};

/// The particles of a state that may sleep.
template <class S>
struct Sleepers {
  using Scalar = ScalarOf<S>;
  static constexpr int dim = S::dimensions;
  static constexpr bool spins = S::template has<Spin>;
  using Vector = Eigen::Matrix<Scalar, dim, 1>;
  using Turn = Eigen::Matrix<Scalar, spins ? Spin::rows(dim) : dim, 1>;
  static auto spin_of(auto& state, Index i) {
    if constexpr (spins) return state.omega.col(i);
    else return state.v.col(i);  // not used
  }

  enum class Kind : std::uint8_t {
    held,     ///< by the user
    awake,    ///<
    watched,  ///< slow: computed as any other
    asleep    ///< not computed
  };
  struct Sleeper {
    Kind kind = Kind::awake;
    bool moves = false;                ///< held by the user, with a velocity or a spin
    std::uint64_t properties = 0;      ///< fingerprint of its mass, radius …
    std::uint64_t seen = 0;            ///< fingerprint of its numbers in the state: asleep, or held at rest
    std::int32_t expired = 0;          ///< how often its sleep has expired
    std::int32_t quiet = 0;            ///< steps
    double impulse = 0;                ///< [force] left out while it sleeps
    double since = 0;                  ///< [time] by the clock: quiet, or asleep, from then on
    double expires = 0;                ///< [time] by the clock: when its sleep does
    double slept = 0;                  ///< [time] of which what was left out has not been given back
    Vector rest = Vector::Zero();      ///< r of one asleep, held or watched, from where on it counts as moved [length]
    Vector sample = Vector::Zero();    ///< r at the last check [length]
    Vector velocity = Vector::Zero();  ///< v when it became quiet [length/time]
    Turn spin = Turn::Zero();          ///< ω then [1/time]
    Vector stopped = Vector::Zero();   ///< v when it fell asleep [length/time]
    Turn stopped_spin = Turn::Zero();  ///< of ω then, what rolled with v [1/time]
    Vector push = Vector::Zero();      ///< its mean acceleration before [length/time²]
    Turn turn = Turn::Zero();          ///< its mean angular acceleration before [1/time²]
    bool is_driven = false;            ///< asleep, drive and twist are known
    Vector drive = Vector::Zero();     ///< its acceleration by terms that may change with time, when it fell asleep
    Turn twist = Turn::Zero();         ///< its angular acceleration by these

    [[nodiscard]] bool is_asleep() const { return kind == Kind::asleep; }
    [[nodiscard]] bool is_computed() const { return kind == Kind::awake || kind == Kind::watched; }
    /// It stays as it is, so that a change of it is an edit.
    [[nodiscard]] bool rests() const { return kind == Kind::asleep || (kind == Kind::held && !moves); }
    /// A particle that touches it can't sleep.
    [[nodiscard]] bool disturbs() const { return kind == Kind::awake || (kind == Kind::held && moves); }
  };

  SleepOptions options;
  std::vector<Sleeper> all;
  std::vector<std::int64_t> id;
  std::vector<std::uint8_t> is_computed;  ///< of each, whether it is awake or watched
  std::vector<std::int32_t> supports;     ///< those that are held by the user and move
  SleepReport report;
  std::int64_t free = 0;          ///< particles not held by the user
  double clock = 0, checked = 0;  ///< [time] of all steps; at the last check
  double review = 0;              ///< [time] by the clock: no sleep expires before
  double impulse_rate = 0;        ///< [force] Σ of those asleep
  std::uint64_t seen = 0;         ///< Σ of those that rest
  std::uint64_t scene = 0;        ///< fingerprint of the box and what else all particles share
  std::int64_t since_check = 0;   ///< steps
  std::int64_t sets = 0;          ///< active sets made since the last check
  double unrest = 0;     ///< recent changes of the active set per step, 0 … 1; 1.5 after a check that woke all
  bool edited = false;   ///< the state was changed after the step
  bool changed = false;  ///< the kind of a body has changed since lists were made
  explicit Sleepers(SleepOptions given) : options{given} {}
  [[nodiscard]] Sleeper& operator[](Index i) { return all[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const Sleeper& operator[](Index i) const { return all[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Index size() const { return static_cast<Index>(all.size()); }
  [[nodiscard]] Scalar speed() const { return static_cast<Scalar>(options.speed); }

  void archive(auto& ar) {
    using T = Sleeper;
    ar.columns("particles", all, "kind", &T::kind, "moves", &T::moves, "properties", &T::properties, "seen", &T::seen,
               "expired", &T::expired, "quiet", &T::quiet, "impulse", &T::impulse, "since", &T::since, "expires",
               &T::expires, "slept", &T::slept, "rest", &T::rest, "sample", &T::sample, "velocity", &T::velocity,
               "spin", &T::spin, "stopped", &T::stopped, "stopped_spin", &T::stopped_spin, "push", &T::push, "turn",
               &T::turn, "is_driven", &T::is_driven, "drive", &T::drive, "twist", &T::twist);
    ar("id", id, "report", report, "since_check", since_check, "clock", clock, "checked", checked, "review", review,
       "impulse_rate", impulse_rate, "seen", seen, "free", free, "sets", sets, "unrest", unrest, "edited", edited,
       "changed", changed, "scene", scene);
    ar.check(id.size() == all.size());
    for (const Sleeper& x : all)
      ar.check(x.kind <= Kind::asleep && 0 <= x.expired && x.expired <= 30 && 0 <= x.quiet && x.quiet < 1 << 30);
    find_lists();
  }

  void find_lists() {
    is_computed.resize(all.size());
    supports.clear();
    for (std::size_t i = 0; i < all.size(); ++i) {
      is_computed[i] = all[i].is_computed() ? 1 : 0;
      if (all[i].kind == Kind::held && all[i].moves) supports.push_back(static_cast<std::int32_t>(i));
    }
  }
  void count() {
    find_lists();
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
    const double slept = clock - one.since;
    start(one, kind);
    one.slept = slept;
    one.velocity.setZero();
    one.sample = one.rest;
    is_computed[static_cast<std::size_t>(i)] = 1;
    changed = true;
  }
  /// One that was held by the user is computed.
  void start_awake(Index i) { start((*this)[i], Kind::awake), (*this)[i].expired = 0; }
  void wake_all() {
    begin_checks();
    for (Index i = 0; i < size(); ++i)
      if ((*this)[i].is_asleep()) wake(i, Kind::awake), (*this)[i].expired = 0;
  }
  /// None has been quiet for steps that weren't done.
  void begin_checks() { since_check = 0, checked = clock; }
  [[nodiscard]] static bool moves(const S& state, Index i) {
    return (state.v.col(i).array() != 0).any() || (spin_of(state, i).array() != 0).any();
  }
  [[nodiscard]] bool is_slow(const S& state, Index i) const {
    return size_of(state, i, state.v.col(i), spin_of(state, i) - (*this)[i].spin) < speed();
  }

  /// Wakes those whose acceleration by terms that may change with time is another one than when they fell asleep: by so much that it
  /// would have made them as fast as `speed` since.
  void wake_driven(const S& state, const auto& accelerations) {
    for (Index i = 0; i < size(); ++i) {
      Sleeper& one = (*this)[i];
      if (!one.is_asleep()) continue;
      const Vector a = std::get<0>(accelerations).col(i);
      Turn alpha = Turn::Zero();
      if constexpr (spins) alpha = std::get<1>(accelerations).col(i);
      if (!std::exchange(one.is_driven, true)) one.drive = a, one.twist = alpha;
      const Scalar change = size_of(state, i, a - one.drive, alpha - one.twist);
      if (!(change * static_cast<Scalar>(clock - one.since) < speed())) wake(i, Kind::watched);
    }
    if (changed) begin_checks();
  }

  /// Wakes those whose sleep has expired, and finds out which of those computed are quiet.
  void check(const S& state, const std::vector<std::int32_t>& computed) {
    const auto elapsed = static_cast<Scalar>(clock - checked);
    for (const Index i : computed) {
      Sleeper& one = (*this)[i];
      if (!one.is_computed()) continue;
      const bool quiet = is_slow(state, i) && (state.r.col(i) - one.sample).norm() < speed() * elapsed;
      one.quiet = quiet ? one.quiet + static_cast<std::int32_t>(since_check) : 0;
      if (!quiet) {
        changed = changed || one.kind == Kind::watched;
        one.kind = Kind::awake;
        one.slept = 0;
        begin(state, i);
      } else if (one.kind == Kind::awake && one.quiet >= options.steps) {
        one.kind = Kind::watched;
        one.rest = state.r.col(i);
        changed = true;
      }
      one.sample = state.r.col(i);
    }
    if (clock >= review) {
      for (Index i = 0; i < size(); ++i)
        if (Sleeper& one = (*this)[i]; one.is_asleep() && clock >= one.expires) {
          wake(i, Kind::watched);
          one.expired = std::min(one.expired + 1, 30);
        }
      count();
    }
    // Remembered for some fifty checks: particles that were put to sleep and woken in vain aren't put to sleep again at once.
    unrest = std::max(0.97 * unrest, std::min(1.0, static_cast<double>(sets) / static_cast<double>(since_check)));
    sets = 0;
    begin_checks();
  }
  /// Whether a watched particle is at rest: its mean acceleration won't soon make it as fast as `speed`, and is not the one that went
  /// on while it slept the last time.
  [[nodiscard]] bool may_sleep(S& state, Index i) {
    Sleeper& one = (*this)[i];
    if (one.kind != Kind::watched || one.quiet < options.steps) return false;
    const auto seen_for = static_cast<Scalar>(clock - one.since);
    const Vector a = (state.v.col(i) - one.velocity) / seen_for;
    const Turn alpha = (spin_of(state, i) - one.spin) / seen_for;
    const Scalar lasts = unseen_for(state, i, state.v.col(i), a, alpha);
    const bool goes_on =
        one.slept > 0 && size_of(state, i, a - one.push, alpha - one.turn) < size_of(state, i, one.push, one.turn) / 2;
    if (goes_on) {  // as it is now, without a trembling from before
      one.push = a, one.turn = alpha;
      give_back(state, i);
    }
    if (goes_on || !(lasts > 4 * seen_for)) {  // what pushes it is seen over one such time
      one.quiet = 0;
      begin(state, i);
      return false;
    }
    one.push = a, one.turn = alpha;
    one.impulse = static_cast<double>(state.mass()[i] * size_of(state, i, a, alpha));
    // Many at once.
    const double round = std::ldexp(1.0, std::ilogb(static_cast<double>(std::min(64 * seen_for, lasts / 4))));
    one.expires = round * std::floor((clock + std::ldexp(static_cast<double>(lasts), one.expired)) / round);
    return true;
  }
  void fall_asleep(S& state, Index i) {
    Sleeper& one = (*this)[i];
    one.kind = Kind::asleep;
    is_computed[static_cast<std::size_t>(i)] = 0;
    report.energy_removed += kinetic_energy(state, i);
    one.stopped = state.v.col(i);
    one.stopped_spin = rolling_spin(state, i);
    if constexpr (spins) state.omega.col(i) -= one.stopped_spin;
    one.is_driven = false;
    one.since = clock;
    one.slept = 0;
    state.v.col(i).setZero();
    one.rest = state.r.col(i);
    one.spin = spin_of(state, i);
    one.seen = ParticleFingerprint<S>::of(state, i);
    seen += one.seen;
    review = std::min(review, one.expires);
    impulse_rate += one.impulse;
    ++report.fell_asleep;
    ++report.asleep;
    edited = changed = true;
  }

 private:
  void start(Sleeper& one, Kind kind) const {
    one.kind = kind;
    one.moves = false;
    one.seen = 0, one.quiet = 0, one.impulse = one.expires = one.slept = 0;
    one.since = clock;
  }
  /// |a|, or the acceleration of its surface, whichever is larger.
  [[nodiscard]] static Scalar size_of(const S& state, Index i, const Vector& a, const Turn& alpha) {
    if constexpr (spins) return std::max(a.norm(), state.radius()[i] * alpha.norm());
    else return a.norm();
  }
  /// The time after which |v + a t| or |α| t R is v_s.
  [[nodiscard]] Scalar unseen_for(const S& state, Index i, const Vector& v, const Vector& a, const Turn& alpha) const {
    const Scalar along = a.dot(v), left = speed() * speed() - v.squaredNorm(),
                 root = std::sqrt(along * along + a.squaredNorm() * left);
    const Scalar lasts = along < 0 ? (root - along) / a.squaredNorm() : left / (along + root);
    return std::min(lasts, speed() / size_of(state, i, Vector::Zero(), alpha));
  }
  /// What of ω may roll with v: across v, and no more than v/R.
  [[nodiscard]] static Turn rolling_spin(const S& state, Index i) {
    if constexpr (!spins) return Turn::Zero();
    else {
      const Vector v = state.v.col(i);
      Turn across = state.omega.col(i);
      if constexpr (dim == 3)
        if (v.squaredNorm() > 0) across -= across.dot(v) / v.squaredNorm() * v;
      const Scalar surface = across.norm() * state.radius()[i];
      return surface > v.norm() ? Turn(v.norm() / surface * across) : across;
    }
  }
  [[nodiscard]] static double kinetic_energy(const S& state, Index i) {
    return static_cast<double>(state.mass()[i] * state.v.col(i).squaredNorm()) / 2;
  }
  /// v + aτ, for no longer a τ than a first sleep may last.
  void give_back(S& state, Index i) {
    Sleeper& one = (*this)[i];
    const Scalar time = std::min(static_cast<Scalar>(one.slept), unseen_for(state, i, one.stopped, one.push, one.turn));
    report.energy_removed += kinetic_energy(state, i);
    state.v.col(i) += one.stopped + time * one.push;
    if constexpr (spins) state.omega.col(i) += one.stopped_spin + time * one.turn;
    report.energy_removed -= kinetic_energy(state, i);
    report.impulse_not_applied -= static_cast<double>(state.mass()[i] * time * size_of(state, i, one.push, one.turn));
    one.slept = 0;
    one.expired = 0;
    edited = true;
  }
  void begin(const S& state, Index i) {
    Sleeper& one = (*this)[i];
    one.since = clock;
    one.velocity = state.v.col(i);
    one.spin = spin_of(state, i);
  }
};

}}  // namespace phistep::PHISTEP_ABI
