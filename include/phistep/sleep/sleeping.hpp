/// @file
/// A stepper around a stepper that doesn't compute particles at rest, within limits, and reports what that cost.
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
/// Nothing is dropped in silence: report() has how much kinetic energy was removed and how much ∫|F|dt was not applied,
/// and compare_sleep() runs a scene both ways and prints the difference in the user's own observables.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>
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
#include "phistep/sleep/sleepers.hpp"
#include "phistep/state/particles.hpp"
#include "phistep/state/parts.hpp"

namespace phistep::inline PHISTEP_ABI {

/// A stepper that does not compute particles at rest, and reports what that cost.
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
  Sleeping(Stepper stepper, SleepOptions options) : stepper_{std::move(stepper)}, sleepers_{options} {
    if (!(options.speed >= 0) || !std::isfinite(options.speed) || options.steps <= 0 || options.every <= 0)
      throw std::invalid_argument("phistep: sleeping needs a finite speed >= 0, and numbers of steps > 0");
  }

  /// Advances the state from t to t + dt. [time] On failure it keeps every bit.
  StepReport step(S& state, Scalar t, Scalar dt, Origin origin = Origin::unknown) {
    if (sleepers_.options.speed == 0) return stepper_.step(state, t, dt, origin);
    if (is_all_asleep() && is_changed(state, t, origin)) sleepers_.wake_all();
    if constexpr (requires { stepper_.changes(); })
      if (std::exchange(changes_, stepper_.changes()) != stepper_.changes())
        sleepers_.wake_all();  // the force may be another one
    adopt(state, origin);
    if (put_off_) part(state, false);
    if (is_all_asleep() && std::isfinite(dt) && std::isfinite(t) && t + dt != t &&
        sleepers_.clock + std::abs(dt) < sleepers_.review) {
      ++steps_;
      sleepers_.pass(dt);
      return {Outcome::success, 0, nullptr};
    }
    const StepReport report = stepper_.step(state, t, dt, sleepers_.meddled ? Origin::unknown : origin);
    if (!report) return report;
    sleepers_.meddled = has_other_pairs_ = false;
    ++steps_;
    sleepers_.pass(dt);
    sleepers_.put_back(state);
    if (sleepers_.since_check >= sleepers_.options.every) {
      sleepers_.check(state);
      part_if_possible(state, steps_ / sleepers_.options.every % 4 == 0);
    } else if (sleepers_.changed || (sleepers_.report.asleep > 0 && have_pairs_changed())) {
      part_if_possible(state, false);
    }
    return report;
  }

  [[nodiscard]] int order() const { return stepper_.order(); }
  [[nodiscard]] Statistics statistics() const {
    Statistics all = stepper_.statistics();
    if (sleepers_.options.speed > 0) all.steps = steps_;
    all.sleeping = sleepers_.report.skipped;
    return all;
  }
  [[nodiscard]] SleepReport report() const { return sleepers_.report; }
  [[nodiscard]] bool is_asleep(Index i) const {
    return i < static_cast<Index>(sleepers_.all.size()) && sleepers_.all[static_cast<std::size_t>(i)].is_asleep();
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
    sleepers_.wake_all();
  }
  /// As PhiStepper's.
  [[nodiscard]] std::int64_t changes() const requires requires(const Stepper& inner) { inner.changes(); }
  { return stepper_.changes(); }
  void forget_unsaved() requires HasUnsaved<Stepper> { stepper_.forget_unsaved(); }
  void save(Writer& out) const {
    sleepers_.archive_all(out, sleepers_.all);
    save_parts(out, "report", sleepers_.report, "id", sleepers_.id, "rest", sleepers_.rest, "sample", sleepers_.sample,
               "velocity", sleepers_.velocity, "push", sleepers_.push);
    with_counters(*this, [&out](auto&... part) { save_parts(out, part...); });
  }
  void load(Reader& in, auto&& then) {
    Sleepers<S> read{sleepers_.options};
    read.archive_all(in, read.all);
    in("report", read.report, "id", read.id, "rest", read.rest, "sample", read.sample, "velocity", read.velocity,
       "push", read.push);
    const auto n = static_cast<Index>(read.all.size());
    in.check(static_cast<Index>(read.id.size()) == n);
    for (const Vectors* x : {&read.rest, &read.sample, &read.velocity, &read.push}) in.check(x->cols() == n);
    with_counters(*this, [&](auto&... part) { load_parts(in, then, part...); });
    sleepers_.all = std::move(read.all), sleepers_.id = std::move(read.id), sleepers_.report = read.report;
    sleepers_.rest = std::move(read.rest), sleepers_.sample = std::move(read.sample);
    sleepers_.velocity = std::move(read.velocity), sleepers_.push = std::move(read.push);
    body_ = 0;
    if constexpr (requires { stepper_.changes(); }) changes_ = stepper_.changes();
  }

 private:
  static void with_counters(auto& self, auto&& f) {
    auto& sleepers = self.sleepers_;
    f("steps", self.steps_, "since_check", sleepers.since_check, "clock", sleepers.clock, "checked", sleepers.checked,
      "review", sleepers.review, "impulse_rate", sleepers.impulse_rate, "meddled", sleepers.meddled, "parted",
      sleepers.changed, "free", sleepers.free, "deep", sleepers.deep, "fell_asleep_as", self.fell_asleep_as_, "bodies",
      self.bodies_, "stepper", self.stepper_);
  }

  [[nodiscard]] bool is_all_asleep() const {
    return sleepers_.free == sleepers_.report.asleep && !sleepers_.changed && sleepers_.free > 0;
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
      if (sleepers_.id != state.id()) {
        sleepers_.match(state, [&] { wake_beside_the_erased(state); });
        has_other_pairs_ = true;
      }
      // Flags that this stepper didn't set are the user's.
      for (Index i = 0; i < state.size(); ++i) {
        const bool held = state.body().is_still(i) && !sleepers_[i].flagged;
        if (held) sleepers_[i].kind = Sleeper::Kind::held;
        else if (sleepers_[i].kind == Sleeper::Kind::held) sleepers_[i] = Sleeper{};
        else if (sleepers_[i].kind == Sleeper::Kind::deep && !state.body().is_still(i)) sleepers_.wake(i);
      }
      sleepers_.count();
      body_ = state.body().serial;
      sleepers_.changed = true;
    }
    for (Index i = 0; i < state.size() && origin != Origin::unedited && sleepers_.report.asleep > 0; ++i) {
      if (!sleepers_[i].is_asleep()) continue;
      bool same =
          (state.r.col(i).array() == sleepers_.rest.col(i).array()).all() && (state.v.col(i).array() == 0).all();
      if constexpr (spins) same = same && (state.omega.col(i).array() == 0).all();
      if (!same) sleepers_.wake(i);
    }
    const auto is_flagged = [](const Sleeper& one) { return one.flagged; };
    if (sleepers_.changed &&
        (sleepers_.report.asleep > 0 || std::any_of(sleepers_.all.begin(), sleepers_.all.end(), is_flagged)))
      part(state, false);
  }
  /// The pairs are still those of the step before, and so are the indices.
  void wake_beside_the_erased(const S& state) {
    std::vector<std::uint8_t> is_gone(sleepers_.id.size(), std::uint8_t{1});
    std::size_t k = 0;
    for (std::size_t old = 0; old < sleepers_.id.size(); ++old) {
      while (k < state.id().size() && state.id()[k] < sleepers_.id[old]) ++k;
      if (k < state.id().size() && state.id()[k] == sleepers_.id[old]) is_gone[old] = 0;
    }
    const auto wake_other = [&](Index i, Index j) {
      if (is_gone[static_cast<std::size_t>(i)] != 0 && sleepers_[j].is_asleep()) sleepers_.wake(j);
    };
    if (sleepers_.report.asleep > 0)
      for_each_pair_of(stepper_.force_to_look_at(), stepper_.memory(), [&](Index i, Index j) {
        if (std::max(i, j) >= static_cast<Index>(sleepers_.id.size())) return;
        wake_other(i, j), wake_other(j, i);
      });
  }
  /// All particles that may touch a sleeper before the pairs change again are among them: only then it has to be watched.
  [[nodiscard]] bool have_pairs_changed() {
    const std::int64_t changes = pair_changes_of(stepper_.force_to_look_at());
    return changes < 0 || changes != pair_changes_;
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
  /// Each change of what is computed costs a search for neighbours: particles are left out many at a time.
  void part(S& state, bool leave_out) {
    sleepers_.changed = false;
    pair_changes_ = pair_changes_of(stepper_.force_to_look_at());
    // Until the next step the pairs of particles that came or stayed are unknown: all count as near to each other.
    ring_.assign(sleepers_.all.size(), has_other_pairs_ ? std::uint8_t{2} : std::uint8_t{9});
    for (std::size_t i = 0; i < sleepers_.all.size(); ++i)
      if (sleepers_.all[i].kind == Sleeper::Kind::awake) ring_[i] = 0;
    for (std::uint8_t ring = 0; ring < 2 && sleepers_.report.asleep > 0 && !has_other_pairs_; ++ring)
      for_each_pair_of(stepper_.force_to_look_at(), stepper_.memory(), [&](Index i, Index j) {
        auto &a = ring_[static_cast<std::size_t>(i)], &b = ring_[static_cast<std::size_t>(j)];
        if (a == ring && b > ring + 1) b = static_cast<std::uint8_t>(ring + 1);
        if (b == ring && a > ring + 1) a = static_cast<std::uint8_t>(ring + 1);
      });
    leave_out = leave_out || sleepers_.report.asleep == sleepers_.free;
    bool changed = false;
    std::vector<std::uint8_t> still(sleepers_.all.size(), std::uint8_t{0});
    bool any = false;
    for (std::size_t i = 0; i < sleepers_.all.size(); ++i) {
      Sleeper& one = sleepers_.all[i];
      if (one.is_asleep()) {
        if (ring_[i] <= 2) one.kind = Sleeper::Kind::watched;
        else if (leave_out) one.kind = Sleeper::Kind::deep;
      }
      one.flagged = one.kind == Sleeper::Kind::deep;
      still[i] = one.kind == Sleeper::Kind::held || one.flagged ? 1 : 0;
      any = any || still[i] != 0;
      changed = changed || (still[i] != 0) != state.body().is_still(static_cast<Index>(i));
    }
    if (changed) {
      if (!any) still.clear();
      state.set_still(std::move(still));
    }
    put_off_ = false;
    body_ = state.body().serial;
    sleepers_.count();
    if (!is_all_asleep()) return;
    fell_asleep_as_.remember(Scalar{0}, state);
    bodies_ = bits_of(state.body());
  }

  Stepper stepper_;
  Sleepers<S> sleepers_;
  std::vector<std::uint8_t> ring_;
  std::uint64_t body_ = 0;
  EditGuard<S, false, false> fell_asleep_as_;  // and with these …
  std::uint64_t bodies_ = 0;                   // … properties
  std::int64_t steps_ = 0, pair_changes_ = 0, changes_ = 0;
  bool put_off_ = false;
  bool has_other_pairs_ = false;  // than those of the force's last evaluation
};

}  // namespace phistep::inline PHISTEP_ABI
