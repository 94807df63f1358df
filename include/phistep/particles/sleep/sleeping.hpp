/// @file
/// A stepper around a stepper that doesn't compute particles at rest, within limits, and reports what that cost.
///
///     Sleeping stepper{PhiStepper{grains, force, symplectic_euler}, SleepOptions{.speed = 1e-3}};
///
/// The rule by which a particle falls asleep and wakes is in sleepers.hpp. A sleeper stays where it is, and no force on it is computed;
/// the stepper leaves it out of its active set (base/state/active_set.hpp), lists and springs stay those of all. A particle wakes that
/// the user edits, or whose properties are changed; those beside a sleeper or support that is moved or erased are watched.
/// stepper().force() and reset() wake all, and so does any change where the whole scene sleeps, which makes a step nothing at all.
/// Where more than nine tenths of the bodies would stay awake (six tenths, if the set changes at every step), none is put to sleep. If
/// that shows only after some have fallen asleep, all wake, and the next attempt comes later the fewer could sleep. Terms that may change
/// with time by themselves (uses_time, without a memory) are evaluated for all once in `every` steps, to see which they push otherwise.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "phistep/base/archive/archive_kinds.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/particles/bodies/particles.hpp"
#include "phistep/particles/sleep/sleep_watch.hpp"
#include "phistep/particles/sleep/sleepers.hpp"
#include "phistep/step/equation/origin.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A stepper that does not compute particles at rest, and reports what that cost.
template <class Stepper>
class Sleeping {
 public:
  using ArchivedByParts = void;
  static constexpr const char* part_name = "stepper";
  using S = typename Stepper::StateType;
  using StateType = S;
  using Scalar = ScalarOf<S>;
  static constexpr int dim = S::dimensions;
  static constexpr bool spins = S::template has<Spin>;
  static_assert(solved_blocks<S> == 1 + (spins ? 1 : 0), "phistep: only what moves and turns can fall asleep");
  using Force = std::remove_reference_t<decltype(std::declval<Stepper&>().force_to_look_at())>;
  using View = decltype(S::view(std::declval<const S&>(), S::masses(std::declval<const S&>())));
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
    if (std::exchange(changes_, stepper_.changes()) != stepper_.changes())
      sleepers_.wake_all(), watch_.forget();  // the force may be another one
    const bool is_edited = adopt(state, origin);
    if constexpr (Drives<Force>::value)
      if (sleepers_.report.asleep > 0 && sleepers_.since_check % sleepers_.options.every == 0) look_at_drive(state, t);
    if (is_all_asleep() && std::isfinite(dt) && std::isfinite(t) && t + dt != t &&
        sleepers_.clock + std::abs(dt) < sleepers_.review) {
      ++steps_;
      sleepers_.pass(dt);
      return {Outcome::success, 0, nullptr};
    }
    const StepReport report = stepper_.step(state, t, dt, inner_origin(origin, is_edited));
    if (!report) return report;
    sleepers_.edited = false;
    ++steps_;
    sleepers_.pass(dt);
    try {
      look_around(state, dt);
    } catch (const std::bad_alloc&) {  // behind a step it is too late to fail: put off until the next
      watch_.forget();
      sleepers_.changed = true;
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
  [[nodiscard]] bool is_asleep(Index i) const { return i < sleepers_.size() && sleepers_[i].is_asleep(); }
  [[nodiscard]] const char* solver_name() const { return stepper_.solver_name(); }
  [[nodiscard]] auto& force_to_look_at() { return stepper_.force_to_look_at(); }
  [[nodiscard]] const auto& memory() const { return stepper_.memory(); }
  [[nodiscard]] const auto& masses() const { return stepper_.masses(); }
  [[nodiscard]] Stepper& stepper() { return stepper_; }
  [[nodiscard]] const Stepper& stepper() const { return stepper_; }
  /// The next step wakes all, too.
  void reset() { stepper_.reset(); }
  /// As PhiStepper's.
  [[nodiscard]] std::int64_t changes() const { return stepper_.changes(); }
  void forget_unsaved() requires HasUnsaved<Stepper> { stepper_.forget_unsaved(); }
  void archive(auto& ar) {
    ar("sleepers", sleepers_, "steps", steps_, "stepper", stepper_);
    ar.at_last([this] {
      watch_.forget();
      body_ = 0;
      changes_ = stepper_.changes();
    });
  }

 private:
  [[nodiscard]] bool is_all_asleep() const {
    return sleepers_.free == sleepers_.report.asleep && !sleepers_.changed && sleepers_.free > 0 &&
           sleepers_.supports.empty();
  }

  /// Follows what the user did to the particles since the last step. True where the state was found to be edited.
  [[nodiscard]] bool adopt(const S& state, Origin origin) {
    const bool was_all_asleep = is_all_asleep();
    bool is_other = false;
    if (body_ != state.body().serial) {
      const bool was_changed = sleepers_.changed;
      is_other = watch_.adopt_bodies(sleepers_, state);
      part();
      if (is_other || was_changed) ++sleepers_.sets;  // a run that resumes makes the set anew that it had
      body_ = state.body().serial;
    }
    const bool is_edited =
        origin == Origin::unknown && sleepers_.report.asleep > 0 && watch_.is_edited(sleepers_, state, active_->list());
    if (is_edited) watch_.adopt_edits(sleepers_, state);
    if (was_all_asleep && (is_other || is_edited)) sleepers_.wake_all();
    if (sleepers_.changed) change_set();
    return is_edited;
  }
  /// What the stepper inside may rely on.
  [[nodiscard]] Origin inner_origin(Origin origin, bool is_edited) const {
    if (is_edited || sleepers_.report.asleep == 0) return sleepers_.edited ? origin.with(Origin::unknown) : origin;
    return origin.with(origin == Origin::unedited && !sleepers_.edited ? Origin::unedited : Origin::rest_unedited);
  }

  /// Whether a term may push otherwise where nothing but time has changed.
  template <class F>
  struct Drives : std::bool_constant<ForceTraits<F, View, RateOf<S>>::uses_time && !remembers<F>> {};
  template <class... T>
  struct Drives<Sum<T...>> : std::disjunction<Drives<Unwrapped<T>>...> {};

  void look_at_drive(const S& state, Scalar t) {
    const auto masses = S::masses(state);
    RateOf<S> rate = make_rate<S>(state);
    const auto accelerations = RateOf<S>::blocks(rate);
    set_zero(accelerations);
    for_each_summand(stepper_.force_to_look_at(), [&]<class F>(F& term) {
      if constexpr (Drives<F>::value) add_force(term, t, S::view(state, masses), NoMemory{}, rate);
    });
    static_cast<void>(divide_by_mass(accelerations, masses));
    sleepers_.wake_driven(state, accelerations);
    if (sleepers_.changed) change_set();
  }
  /// After a step: wakes those that a fast particle reaches, and from time to time puts others to sleep.
  void look_around(S& state, Scalar dt) {
    auto& force = stepper_.force_to_look_at();
    const auto& memory = stepper_.memory();
    if (sleepers_.report.asleep > 0) {
      watch_.follow_pairs(sleepers_, force, memory);
      watch_.wake_reached(sleepers_, state, dt);
    }
    if (sleepers_.since_check >= sleepers_.options.every) {
      sleepers_.check(state, active_->list());
      if (sleepers_.report.asleep == 0) watch_.look_at_supports(sleepers_, state);
      if (sleepers_.changed) change_set();
      watch_.lull(sleepers_, state, dt, force, memory);
    }
    if (sleepers_.changed) change_set();
  }
  void change_set() {
    part();
    ++sleepers_.sets;
  }
  /// Makes the active set, and the lists of particles that are awake, watched, asleep.
  void part() {
    const std::shared_ptr<ActiveSet> active = sets_.take();
    active->assign(sleepers_.is_computed, next_serial());
    active_ = active;
    watch_.follow_kinds(sleepers_, active->list());
    stepper_.set_active(sleepers_.report.asleep == 0 ? nullptr : active_);
    sleepers_.changed = false;
  }

  Stepper stepper_;
  Sleepers<S> sleepers_;
  SleepWatch<S> watch_;
  Recycled<ActiveSet> sets_;
  std::shared_ptr<const ActiveSet> active_;
  std::uint64_t body_ = 0;
  std::int64_t steps_ = 0, changes_ = 0;
};

/// Runs a scene with sleeping and without, and prints the difference in the user's observables.
/// @param scene        scene(options) runs it all and returns what the observables are read from
/// @param observables  pairs of a name and a function of that result to a number
template <class OStream, class Scene, class... Observable>
void compare_sleep(OStream& out, SleepOptions options, Scene&& scene,
                   const std::pair<const char*, Observable>&... observables) {
  const auto asleep = scene(options);
  options.speed = 0;
  const auto awake = scene(options);
  const auto print = [&](const auto& one) {
    const auto a = static_cast<double>(one.second(asleep)), b = static_cast<double>(one.second(awake));
    out << "  " << one.first << ": " << a << " with sleeping, " << b << " without, difference " << a - b << '\n';
  };
  (print(observables), ...);
}

}}  // namespace phistep::PHISTEP_ABI
