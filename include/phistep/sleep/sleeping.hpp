/// @file
/// A stepper around a stepper that leaves particles at rest alone, within a budget, and says what that cost.
///
///     Sleeping stepper{PhiStepper{grains, force, symplectic_euler}, SleepOptions{.speed = 1e-3}};
///
/// A particle falls asleep when it has been slower than `speed` for `steps` steps, by its velocity and by the way it has
/// come. It is then held where it is. Those whose neighbours sleep as well are not computed at all; those near a particle that is
/// awake are watched: they take part in each step, and are put back after it. What pushed one during the last `steps` steps
/// adds up, and when it would have made it faster than `speed` it wakes. (Not longer ago: who is held somewhere in a tiny
/// vibration feels a constant force that would have moved it by F/k and no further.) So a blow wakes what it reaches, and
/// an island sleeps on as long as everything around it does. One that a small force had been moving all along is looked at
/// again when that would have made it as fast, then after twice that time, and so on. A particle that the user edits wakes,
/// and all do after stepper().force() and reset(). The whole scene asleep, a step is nothing at all: until anything is
/// changed, the state, a support, a property of the bodies, which then wakes all.
///
/// Not seen: a force that changes with time by itself; and, as long as a particle is awake, that a body held by the user
/// moves or goes, under one that sleeps.
///
/// Nothing is dropped in silence: report() tells how much kinetic energy was removed and how much ∫|F|dt was not applied,
/// and compare_sleep() runs a scene both ways and prints the difference in the user's own observables.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <new>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/archive/archive.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/pairs/acting_pairs.hpp"
#include "phistep/problem/edit_guard.hpp"
#include "phistep/problem/transaction.hpp"
#include "phistep/simd/fingerprint.hpp"
#include "phistep/sleep/sleep_report.hpp"
#include "phistep/state/particles.hpp"
#include "phistep/state/parts.hpp"

namespace phistep::inline PHISTEP_ABI {

template <class Stepper>
class Sleeping {
 public:
  static constexpr const char* part_name = "stepper";
  using S = typename Stepper::StateType;
  using StateType = S;
  using Scalar = ScalarOf<S>;
  using Vectors = typename S::Vectors;
  static constexpr int dim = S::dimensions;
  static constexpr bool spins = S::template has<Spin>;
  static_assert(solved_blocks<S> == 1 + (spins ? 1 : 0), "phistep: only what moves and turns can fall asleep");
  using Force = std::remove_reference_t<decltype(std::declval<Stepper&>().force_to_look_at())>;
  static_assert(tells_its_pairs<Force, dim>,
                "phistep: a term doesn't tell who acts on whom (for_each_pair(memory, f), or acts_on_each): what its "
                "forces move can't be let sleep");

  /// @throws std::invalid_argument unless speed is finite and >= 0, steps and every > 0
  Sleeping(Stepper stepper, SleepOptions options) : stepper_{std::move(stepper)}, options_{options} {
    if (!(options.speed >= 0) || !std::isfinite(options.speed) || options.steps <= 0 || options.every <= 0)
      throw std::invalid_argument("phistep: sleeping needs a finite speed >= 0, and numbers of steps > 0");
  }

  /// Advances the state from t to t + dt. [time] On failure it keeps every bit.
  StepReport step(S& state, Scalar t, Scalar dt, Origin origin = Origin::unknown) {
    if (options_.speed == 0) return stepper_.step(state, t, dt, origin);
    if (is_all_asleep() && is_changed(state, t, origin)) wake_all();
    if constexpr (requires { stepper_.changes(); })
      if (std::exchange(changes_, stepper_.changes()) != stepper_.changes())
        wake_all();  // the force may be another one
    adopt(state, origin);
    if (put_off_) part(state, false);
    if (is_all_asleep() && std::isfinite(dt) && std::isfinite(t) && t + dt != t && clock_ + std::abs(dt) < review_) {
      clock_ += std::abs(dt);
      account(std::abs(dt));
      ++steps_;
      ++since_check_;
      return {Outcome::success, 0, nullptr};
    }
    const StepReport report = stepper_.step(state, t, dt, meddled_ ? Origin::unknown : origin);
    if (!report) return report;
    meddled_ = has_other_pairs_ = false;
    ++steps_;
    ++since_check_;
    clock_ += std::abs(dt);
    account(std::abs(dt));
    put_back(state);
    if (since_check_ >= options_.every) {
      check(state);
      part_if_possible(state, steps_ / options_.every % 4 == 0);
    } else if (parted_ || (report_.asleep > 0 && have_pairs_changed())) {
      part_if_possible(state, false);
    }
    return report;
  }

  [[nodiscard]] int order() const { return stepper_.order(); }
  [[nodiscard]] Statistics statistics() const {
    Statistics all = stepper_.statistics();
    if (options_.speed > 0) all.steps = steps_;
    all.sleeping = report_.skipped;
    return all;
  }
  [[nodiscard]] SleepReport report() const { return report_; }
  [[nodiscard]] bool is_asleep(Index i) const {
    return i < static_cast<Index>(who_.size()) && who_[static_cast<std::size_t>(i)].kind >= Kind::watched;
  }
  [[nodiscard]] const char* solver_name() const { return stepper_.solver_name(); }
  [[nodiscard]] bool keeps_factors() const { return stepper_.keeps_factors(); }
  /// As PhiStepper's.
  [[nodiscard]] auto& force_to_look_at() { return stepper_.force_to_look_at(); }
  [[nodiscard]] const auto& memory() const { return stepper_.memory(); }
  [[nodiscard]] const auto& masses() const { return stepper_.masses(); }
  [[nodiscard]] Stepper& stepper() { return stepper_; }
  [[nodiscard]] const Stepper& stepper() const { return stepper_; }
  /// Wakes all, too.
  void reset() {
    stepper_.reset();
    wake_all();
  }
  /// As PhiStepper's.
  [[nodiscard]] std::int64_t changes() const requires requires(const Stepper& inner) { inner.changes(); }
  { return stepper_.changes(); }
  void forget_unsaved() requires HasUnsaved<Stepper> { stepper_.forget_unsaved(); }
  void save(Writer& out) const {
    archive_sleepers(out, who_);
    save_parts(out, "report", report_, "id", id_, "rest", rest_, "sample", sample_, "velocity", velocity_, "push",
               push_);
    with_counters(*this, [&out](auto&... part) { save_parts(out, part...); });
  }
  void load(Reader& in, auto&& then) {
    std::vector<Sleeper> who;
    SleepReport report;
    std::vector<std::int64_t> id;
    std::array<Vectors, 4> vectors;
    archive_sleepers(in, who);
    in("report", report, "id", id, "rest", vectors[0], "sample", vectors[1], "velocity", vectors[2], "push",
       vectors[3]);
    const auto n = static_cast<Index>(who.size());
    in.check(static_cast<Index>(id.size()) == n);
    for (const Vectors& x : vectors) in.check(x.cols() == n);
    with_counters(*this, [&](auto&... part) { load_parts(in, then, part...); });
    who_ = std::move(who), report_ = report, id_ = std::move(id);
    rest_ = std::move(vectors[0]), sample_ = std::move(vectors[1]);
    velocity_ = std::move(vectors[2]), push_ = std::move(vectors[3]);
    body_ = 0;
    if constexpr (requires { stepper_.changes(); }) changes_ = stepper_.changes();
  }

 private:
  enum class Kind : std::uint8_t {
    held,     // by the user
    awake,    //
    watched,  // asleep, near a particle that is awake
    deep      // asleep, not computed
  };
  struct Sleeper {
    Kind kind = Kind::awake;
    bool flagged = false;    // its `still` is this stepper's, not the user's
    std::int32_t naps = 0;   // how often it has been looked at and found as it was
    std::int32_t quiet = 0;  // steps
    double impulse = 0;      // [force·time/time] |F| left out while deep
    double since = 0;        // on clock_ [time] it has been quiet
    double expires = 0;      // on clock_ [time]
  };
  static void archive_sleepers(auto& ar, auto& who) {
    ar.columns("who", who, "kind", &Sleeper::kind, "flagged", &Sleeper::flagged, "naps", &Sleeper::naps, "quiet",
               &Sleeper::quiet, "impulse", &Sleeper::impulse, "since", &Sleeper::since, "expires", &Sleeper::expires);
    for (const Sleeper& x : who)
      ar.check(x.kind <= Kind::deep && 0 <= x.naps && x.naps <= 30 && 0 <= x.quiet && x.quiet < 1 << 30);
  }
  static void with_counters(auto& self, auto&& f) {
    f("steps", self.steps_, "since_check", self.since_check_, "clock", self.clock_, "checked", self.checked_, "review",
      self.review_, "impulse_rate", self.impulse_rate_, "meddled", self.meddled_, "parted", self.parted_, "free",
      self.free_, "deep", self.deep_, "fell_asleep_as", self.fell_asleep_as_, "bodies", self.bodies_, "stepper",
      self.stepper_);
  }

  [[nodiscard]] Sleeper& who(Index i) { return who_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool is_all_asleep() const { return free_ == report_.asleep && !parted_ && free_ > 0; }
  [[nodiscard]] Scalar speed_squared() const {
    return static_cast<Scalar>(options_.speed) * static_cast<Scalar>(options_.speed);
  }

  /// Whether anything isn't as it was when the last one fell asleep.
  [[nodiscard]] bool is_changed(const S& state, Scalar t, Origin origin) const {
    if (body_ != state.body().serial && bodies_ != bits_of(state.body())) return true;
    return origin != Origin::unedited && !fell_asleep_as_.holds(t, state);
  }
  [[nodiscard]] static std::uint64_t bits_of(const auto& body) {
    Writer out;
    out(body);
    return fingerprint(out.bytes().data(), static_cast<std::ptrdiff_t>(out.bytes().size()));
  }
  /// Follows what the user did to the particles since the last step.
  void adopt(S& state, Origin origin) {
    if (body_ != state.body().serial) {
      if (id_ != state.id()) match(state);
      // Flags that this stepper didn't set are the user's.
      for (Index i = 0; i < state.size(); ++i) {
        const bool held = state.body().is_still(i) && !who(i).flagged;
        if (held) who(i).kind = Kind::held;
        else if (who(i).kind == Kind::held) who(i) = Sleeper{};
        else if (who(i).kind == Kind::deep && !state.body().is_still(i)) wake(i);
      }
      count();
      body_ = state.body().serial;
      parted_ = true;
    }
    for (Index i = 0; i < state.size() && origin != Origin::unedited && report_.asleep > 0; ++i) {
      if (who(i).kind < Kind::watched) continue;
      bool same = (state.r.col(i).array() == rest_.col(i).array()).all() && (state.v.col(i).array() == 0).all();
      if constexpr (spins) same = same && (state.omega.col(i).array() == 0).all();
      if (!same) wake(i);
    }
    const auto is_flagged = [](const Sleeper& one) { return one.flagged; };
    if (parted_ && (report_.asleep > 0 || std::any_of(who_.begin(), who_.end(), is_flagged))) part(state, false);
  }
  /// Particles came or went: ids grow from left to right.
  void match(const S& state) {
    std::vector<Sleeper> now(static_cast<std::size_t>(state.size()));
    Vectors rest = state.r, sample = state.r, velocity = state.v, push = Vectors::Zero(dim, state.size());
    std::vector<std::int64_t> id = state.id();
    wake_beside_the_erased(state);
    std::size_t old = 0;
    for (std::size_t k = 0; k < state.id().size(); ++k) {
      while (old < id_.size() && id_[old] < state.id()[k]) ++old;
      if (old == id_.size() || id_[old] != state.id()[k]) continue;
      const auto from = static_cast<Index>(old), to = static_cast<Index>(k);
      now[k] = who_[old];
      rest.col(to) = rest_.col(from), sample.col(to) = sample_.col(from);
      velocity.col(to) = velocity_.col(from), push.col(to) = push_.col(from);
    }
    has_other_pairs_ = true;
    who_ = std::move(now);
    rest_ = std::move(rest), sample_ = std::move(sample), velocity_ = std::move(velocity), push_ = std::move(push);
    id_ = std::move(id);
  }
  /// The pairs are still those of the step before, and so are the indices.
  void wake_beside_the_erased(const S& state) {
    std::vector<std::uint8_t> is_gone(id_.size(), std::uint8_t{1});
    std::size_t k = 0;
    for (std::size_t old = 0; old < id_.size(); ++old) {
      while (k < state.id().size() && state.id()[k] < id_[old]) ++k;
      if (k < state.id().size() && state.id()[k] == id_[old]) is_gone[old] = 0;
    }
    const auto wake_other = [&](Index i, Index j) {
      if (is_gone[static_cast<std::size_t>(i)] != 0 && who(j).kind >= Kind::watched) wake(j);
    };
    if (report_.asleep > 0)
      for_each_pair_of(stepper_.force_to_look_at(), stepper_.memory(), [&](Index i, Index j) {
        if (std::max(i, j) >= static_cast<Index>(id_.size())) return;
        wake_other(i, j), wake_other(j, i);
      });
  }
  void count() {
    free_ = deep_ = report_.asleep = 0;
    impulse_rate_ = 0;
    review_ = std::numeric_limits<double>::infinity();
    for (const Sleeper& one : who_) {
      free_ += one.kind != Kind::held;
      deep_ += one.kind == Kind::deep;
      if (one.kind < Kind::watched) continue;
      ++report_.asleep;
      review_ = std::min(review_, one.expires);
      if (one.kind == Kind::deep) impulse_rate_ += one.impulse;
    }
  }
  void account(Scalar dt) {
    report_.skipped += deep_;
    report_.impulse_not_applied += impulse_rate_ * static_cast<double>(dt);
  }
  void wake(Index i) {
    who(i) = Sleeper{.flagged = who(i).flagged, .since = clock_};
    ++report_.woken;
    --report_.asleep;
    parted_ = true;
  }

  void wake_all() {
    // None has been quiet for the steps that weren't done.
    since_check_ = 0;
    checked_ = clock_;
    for (Index i = 0; i < static_cast<Index>(who_.size()); ++i)
      if (who(i).kind >= Kind::watched) wake(i);
  }

  /// Undoes what the step did to those that are watched, and wakes those that were pushed too far.
  void put_back(S& state) {
    if (report_.asleep == deep_) return;
    const Scalar fading = 1 - 1 / static_cast<Scalar>(options_.steps);
    for (Index i = 0; i < state.size(); ++i) {
      if (who(i).kind != Kind::watched) continue;
      push_.col(i) = fading * push_.col(i) + state.v.col(i);
      report_.impulse_not_applied += static_cast<double>(state.mass()[i] * state.v.col(i).norm());
      // The push is the scene's; the energy is what the step gave it.
      stop(state, i);
      state.r.col(i) = rest_.col(i);
      meddled_ = true;
      if (push_.col(i).squaredNorm() > speed_squared()) wake(i);
    }
  }
  /// All particles that may touch a sleeper before the pairs change again are among them: only then it has to be watched.
  [[nodiscard]] bool have_pairs_changed() {
    const std::int64_t changes = pair_changes_of(stepper_.force_to_look_at());
    return changes < 0 || changes != pair_changes_;
  }
  void stop(S& state, Index i) {
    Scalar twice = state.mass()[i] * state.v.col(i).squaredNorm();
    state.v.col(i).setZero();
    if constexpr (spins) {
      twice += state.body().inertia(i) * state.omega.col(i).squaredNorm();
      state.omega.col(i).setZero();
    }
    report_.energy_removed += static_cast<double>(twice) / 2;
  }

  /// Who has been quiet long enough, and whose sleep has to be looked at.
  void check(S& state) {
    const auto elapsed = static_cast<Scalar>(clock_ - checked_);
    for (Index i = 0; i < state.size(); ++i) {
      Sleeper& one = who(i);
      if (one.kind >= Kind::watched && clock_ >= one.expires) {
        const std::int32_t naps = one.naps;
        wake(i);
        one.naps = std::min(naps + 1, 30);
      }
      if (one.kind != Kind::awake) continue;
      const bool quiet = is_quiet(state, i, elapsed);
      one.quiet = quiet ? one.quiet + static_cast<std::int32_t>(since_check_) : 0;
      if (one.quiet >= options_.steps && may_sleep(state, i)) {
        fall_asleep(state, i);
      } else if (!quiet || one.quiet >= options_.steps) {  // what has pushed it is seen over one such time
        one.quiet = 0;
        one.since = clock_;
        velocity_.col(i) = state.v.col(i);
      }
      sample_.col(i) = state.r.col(i);
    }
    since_check_ = 0;
    checked_ = clock_;
  }
  [[nodiscard]] bool is_quiet(const S& state, Index i, Scalar elapsed) const {
    const Scalar limit = speed_squared();
    bool quiet = state.v.col(i).squaredNorm() < limit &&
                 (state.r.col(i) - sample_.col(i)).squaredNorm() < limit * elapsed * elapsed;
    if constexpr (spins) {
      const Scalar R = state.radius()[i];
      quiet = quiet && R * R * state.omega.col(i).squaredNorm() < limit;
    }
    return quiet;
  }
  /// What has been pushing it, on the mean, goes on unseen until that would have made it as fast as `speed`. Where that is
  /// soon, it is not at rest.
  [[nodiscard]] bool may_sleep(const S& state, Index i) {
    Sleeper& one = who(i);
    const auto seen_for = static_cast<Scalar>(clock_ - one.since);
    const Scalar acceleration = (state.v.col(i) - velocity_.col(i)).norm() / seen_for;
    const Scalar lasts = static_cast<Scalar>(options_.speed) / acceleration;
    one.impulse = static_cast<double>(state.mass()[i] * acceleration);
    // Many at once: each time that who is computed changes, neighbours are sought anew.
    const double round = std::ldexp(1.0, std::ilogb(64 * static_cast<double>(seen_for)));
    one.expires = round * std::ceil((clock_ + std::ldexp(static_cast<double>(lasts), one.naps)) / round);
    return lasts > 4 * seen_for;
  }
  void fall_asleep(S& state, Index i) {
    who(i).kind = Kind::watched;
    stop(state, i);
    rest_.col(i) = state.r.col(i);
    push_.col(i).setZero();
    ++report_.fell_asleep;
    ++report_.asleep;
    meddled_ = parted_ = true;
  }

  /// Behind a step it is too late to fail: without the memory for it, it is put off until the next.
  void part_if_possible(S& state, bool leave_out) {
    try {
      part(state, leave_out);
    } catch (const std::bad_alloc&) {
      put_off_ = true;
    }
  }
  /// Parts sleepers into those within two neighbours of a particle that is awake, watched from now on, and the others.
  /// Each change of who is computed costs a search for neighbours, so that those who needn't be are left out many at a time.
  void part(S& state, bool leave_out) {
    parted_ = false;
    pair_changes_ = pair_changes_of(stepper_.force_to_look_at());
    // Until the next step the pairs of particles that came or stayed are unknown: all count as near to each other.
    ring_.assign(who_.size(), has_other_pairs_ ? std::uint8_t{2} : std::uint8_t{9});
    for (std::size_t i = 0; i < who_.size(); ++i)
      if (who_[i].kind == Kind::awake) ring_[i] = 0;
    for (std::uint8_t ring = 0; ring < 2 && report_.asleep > 0 && !has_other_pairs_; ++ring)
      for_each_pair_of(stepper_.force_to_look_at(), stepper_.memory(), [&](Index i, Index j) {
        auto &a = ring_[static_cast<std::size_t>(i)], &b = ring_[static_cast<std::size_t>(j)];
        if (a == ring && b > ring + 1) b = static_cast<std::uint8_t>(ring + 1);
        if (b == ring && a > ring + 1) a = static_cast<std::uint8_t>(ring + 1);
      });
    leave_out = leave_out || report_.asleep == free_;
    bool changed = false;
    std::vector<std::uint8_t> still(who_.size(), std::uint8_t{0});
    bool any = false;
    for (std::size_t i = 0; i < who_.size(); ++i) {
      Sleeper& one = who_[i];
      if (one.kind >= Kind::watched) {
        if (ring_[i] <= 2) one.kind = Kind::watched;
        else if (leave_out) one.kind = Kind::deep;
      }
      one.flagged = one.kind == Kind::deep;
      still[i] = one.kind == Kind::held || one.flagged ? 1 : 0;
      any = any || still[i] != 0;
      changed = changed || (still[i] != 0) != state.body().is_still(static_cast<Index>(i));
    }
    if (changed) {
      if (!any) still.clear();
      state.set_still(std::move(still));
    }
    put_off_ = false;
    body_ = state.body().serial;
    count();
    if (!is_all_asleep()) return;
    fell_asleep_as_.remember(Scalar{0}, state);
    bodies_ = bits_of(state.body());
  }

  Stepper stepper_;
  SleepOptions options_;
  std::vector<Sleeper> who_;
  std::vector<std::int64_t> id_;
  Vectors rest_, sample_, velocity_, push_;  // where sleepers lie; r at the last check; v when it became quiet; Σ Δv
  std::vector<std::uint8_t> ring_;
  std::uint64_t body_ = 0;
  EditGuard<S, false, false> fell_asleep_as_;  // and with these …
  std::uint64_t bodies_ = 0;                   // … properties
  SleepReport report_;
  std::int64_t steps_ = 0, since_check_ = 0, free_ = 0, deep_ = 0, pair_changes_ = 0, changes_ = 0;
  double clock_ = 0, checked_ = 0, review_ = 0, impulse_rate_ = 0;
  bool meddled_ = false, parted_ = false, put_off_ = false;
  bool has_other_pairs_ = false;  // than those that the force tells of
};

}  // namespace phistep::inline PHISTEP_ABI
