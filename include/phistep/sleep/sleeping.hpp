/// @file
/// A stepper around a stepper that doesn't compute particles at rest, within limits, and reports what that cost.
///
///     Sleeping stepper{PhiStepper{grains, force, symplectic_euler}, SleepOptions{.speed = 1e-3}};
///
/// A particle that has been slower than `speed` for `steps` steps, by its velocity and by the way it has come, is watched;
/// if it touches nobody awake (is near, where the force doesn't act by touch) it falls asleep: it stays where it is, and no
/// force on it is computed. Those watched move as any other, and as soon as one is faster than `speed`, or has come further
/// than `speed` lets it between two checks, the sleepers that it touches are watched. So a blow goes through: it wakes what it
/// reaches, and whom it doesn't reach sleeps on. One that a small force had been moving all along is looked at again when
/// that would have made it as fast as `speed`, then after twice that time, and so on. A particle that the user edits wakes, or
/// whose properties are changed; those beside a sleeper or a support that is moved or goes are watched. All wake after
/// stepper().force() and reset(). The whole scene asleep, a step is nothing at all: until anything is changed, which
/// then wakes all.
///
/// Who sleeps is left out of the stepper's active set (state/active_set.hpp): lists and springs stay over all. Where more
/// than nine tenths would be computed anyway, nobody sleeps.
///
/// Not seen: a force that changes with time by itself.
///
/// Nothing is dropped in silence: report() has how much kinetic energy was removed and how much ∫|F|dt was not applied,
/// and compare_sleep() runs a scene both ways and prints the difference in the user's own observables.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/archive/archive.hpp"
#include "phistep/core/recycled.hpp"
#include "phistep/core/statistics.hpp"
#include "phistep/core/step_report.hpp"
#include "phistep/core/version.hpp"
#include "phistep/pairs/acting_pairs.hpp"
#include "phistep/problem/edit_guard.hpp"
#include "phistep/problem/transaction.hpp"
#include "phistep/simd/fingerprint.hpp"
#include "phistep/sleep/sleep_report.hpp"
#include "phistep/sleep/sleepers.hpp"
#include "phistep/sleep/touch_graph.hpp"
#include "phistep/state/active_set.hpp"
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
    if (put_off_) part(state);
    if (is_all_asleep() && std::isfinite(dt) && std::isfinite(t) && t + dt != t &&
        sleepers_.clock + std::abs(dt) < sleepers_.review) {
      ++steps_;
      sleepers_.pass(dt);
      return {Outcome::success, 0, nullptr};
    }
    const StepReport report = stepper_.step(state, t, dt, sleepers_.meddled ? Origin::unknown : origin);
    if (!report) return report;
    sleepers_.meddled = false;
    ++steps_;
    sleepers_.pass(dt);
    try {
      look_around(state, dt);
    } catch (const std::bad_alloc&) {  // behind a step it is too late to fail: put off until the next
      graph_.forget();
      put_off_ = true;
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
               "velocity", sleepers_.velocity);
    with_counters(*this, [&out](auto&... part) { save_parts(out, part...); });
  }
  void load(Reader& in, auto&& then) {
    Sleepers<S> read{sleepers_.options};
    read.archive_all(in, read.all);
    in("report", read.report, "id", read.id, "rest", read.rest, "sample", read.sample, "velocity", read.velocity);
    const auto n = static_cast<Index>(read.all.size());
    in.check(static_cast<Index>(read.id.size()) == n);
    for (const Vectors* x : {&read.rest, &read.sample, &read.velocity}) in.check(x->cols() == n);
    with_counters(*this, [&](auto&... part) { load_parts(in, then, part...); });
    sleepers_.all = std::move(read.all), sleepers_.id = std::move(read.id), sleepers_.report = read.report;
    sleepers_.rest = std::move(read.rest), sleepers_.sample = std::move(read.sample);
    sleepers_.velocity = std::move(read.velocity);
    body_ = 0;
    graph_.forget();
    if constexpr (requires { stepper_.changes(); }) changes_ = stepper_.changes();
  }

 private:
  using Kind = Sleeper::Kind;
  static void with_counters(auto& self, auto&& f) {
    auto& sleepers = self.sleepers_;
    f("steps", self.steps_, "since_check", sleepers.since_check, "clock", sleepers.clock, "checked", sleepers.checked,
      "review", sleepers.review, "impulse_rate", sleepers.impulse_rate, "meddled", sleepers.meddled, "changed",
      sleepers.changed, "free", sleepers.free, "fell_asleep_as", self.fell_asleep_as_, "bodies", self.bodies_, "scene",
      self.scene_, "stepper", self.stepper_);
  }

  [[nodiscard]] bool is_all_asleep() const {
    return sleepers_.free == sleepers_.report.asleep && !sleepers_.changed && sleepers_.free > 0 && !supports_move_;
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
  [[nodiscard]] static std::uint64_t bits_of(const auto& body, Index i) {
    const auto of = [i](const auto& column) { return column.size() == 0 ? 0 : static_cast<double>(column[i]); };
    const double all[] = {of(body.mass), of(body.radius), of(body.type), of(body.charge)};
    return fingerprint(all, 4);
  }
  /// Follows what the user did to the particles since the last step.
  void adopt(S& state, Origin origin) {
    if (body_ != state.body().serial) adopt_bodies(state);
    if (origin != Origin::unedited && sleepers_.report.asleep > 0) find_edits(state);
    if (sleepers_.changed) part(state);
  }
  void adopt_bodies(S& state) {
    const auto& body = state.body();
    if (sleepers_.id != state.id()) {
      sleepers_.match(state, [&] { wake_beside_the_erased(state); });
      graph_.forget();
    }
    Writer box;
    box(body.box, body.inertia_factor);
    const auto scene = fingerprint(box.bytes().data(), static_cast<std::ptrdiff_t>(box.bytes().size()));
    if (std::exchange(scene_, scene) != scene) sleepers_.wake_all();
    for (Index i = 0; i < state.size(); ++i) {
      Sleeper& one = sleepers_[i];
      const std::uint64_t bits = bits_of(body, i);
      if (std::exchange(one.properties, bits) != bits && one.is_asleep()) sleepers_.wake(i, Kind::awake);
      if (body.is_still(i)) {
        if (one.kind != Kind::held) sleepers_.rest.col(i) = state.r.col(i);
        one.kind = Kind::held;
      } else if (one.kind == Kind::held) {
        one = Sleeper{.properties = bits, .since = sleepers_.clock};
      }
    }
    sleepers_.count();
    body_ = body.serial;
    sleepers_.changed = true;
  }
  /// Sleepers and supports that aren't where they were.
  void find_edits(const S& state) {
    for (Index i = 0; i < state.size(); ++i) {
      Sleeper& one = sleepers_[i];
      if (!one.is_asleep() && one.kind != Kind::held) continue;
      const bool stays = (state.r.col(i).array() == sleepers_.rest.col(i).array()).all();
      bool rests = (state.v.col(i).array() == 0).all();
      if constexpr (spins) rests = rests && (state.omega.col(i).array() == 0).all();
      if (one.is_asleep()) {
        if (stays && rests) continue;
        wake_beside(i);
        sleepers_.wake(i, Kind::awake);
      } else {
        if (!stays && !one.moves) wake_beside(i);
        if (rests == one.moves) sleepers_.changed = true;
        sleepers_.rest.col(i) = state.r.col(i);
      }
    }
  }
  /// Whoever may touch i is watched.
  void wake_beside(Index i) {
    if (!graph_.is_of(sleepers_.size())) return sleepers_.wake_all();
    for (const TouchGraph::Edge& edge : graph_.of(i))
      if (sleepers_[edge.other].is_asleep()) sleepers_.wake(edge.other, Kind::watched);
  }
  /// The graph is still that of the step before, and so are the indices.
  void wake_beside_the_erased(const S& state) {
    if (sleepers_.report.asleep == 0) return;
    std::size_t k = 0;
    for (std::size_t old = 0; old < sleepers_.id.size(); ++old) {
      while (k < state.id().size() && state.id()[k] < sleepers_.id[old]) ++k;
      if (k < state.id().size() && state.id()[k] == sleepers_.id[old]) continue;
      wake_beside(static_cast<Index>(old));
    }
  }

  /// After a step: who has become fast, whom that reaches, and from time to time who may sleep.
  void look_around(S& state, Scalar dt) {
    if (sleepers_.report.asleep > 0) {
      if (!knows_pairs()) find_pairs(state), find_frontier(state);
      watch(state, dt);
    }
    if (sleepers_.since_check >= sleepers_.options.every) {
      sleepers_.check(state);
      lull(state, dt);
    }
    if (sleepers_.changed) part(state);
  }
  [[nodiscard]] bool knows_pairs() {
    const std::int64_t changes = pair_changes_of(stepper_.force_to_look_at());
    return graph_.is_of(sleepers_.size()) && changes >= 0 && changes == pair_changes_;
  }
  void find_pairs(const S& state) {
    graph_.build(state.size(),
                 [this](auto&& f) { for_each_pair_of(stepper_.force_to_look_at(), stepper_.memory(), f); });
    pair_changes_ = pair_changes_of(stepper_.force_to_look_at());
  }
  /// f(sleeper) for those on whom i acts.
  void for_each_reached(const S& state, Index i, Scalar dt, auto&& f) {
    for (const TouchGraph::Edge& edge : graph_.of(i))
      if (sleepers_[edge.other].is_asleep() && TouchGraph::acts(state, i, edge, dt)) f(Index{edge.other});
  }
  void watch(const S& state, Scalar dt) {
    const auto wake = [&](Index j) { sleepers_.wake(j, Kind::watched); };
    for (const auto& [i, edge] : frontier_)
      if (sleepers_[edge.other].is_asleep() && TouchGraph::acts(state, i, edge, dt)) wake(edge.other);
    for (const std::int32_t i : watched_) {
      Sleeper& one = sleepers_[i];
      const bool fast = sleepers_.is_fast(state, i);
      if (fast) one.kind = Kind::awake, one.quiet = 0, sleepers_.changed = true;
      else if (!sleepers_.has_moved(state, i, dt)) continue;
      sleepers_.rest.col(i) = state.r.col(i);
      for_each_reached(state, i, dt, wake);
    }
  }
  /// Puts to sleep who is watched and touches nobody awake.
  void lull(S& state, Scalar dt) {
    tired_.clear();
    for (Index i = 0; i < state.size(); ++i)
      if (sleepers_.may_sleep(state, i)) tired_.push_back(static_cast<std::int32_t>(i));
    if (!tired_.empty() && !knows_pairs()) find_pairs(state);
    std::erase_if(tired_, [&](Index i) {
      const auto around = graph_.of(i);
      return std::any_of(around.begin(), around.end(), [&](const TouchGraph::Edge& edge) {
        return sleepers_[edge.other].disturbs() && TouchGraph::acts(state, i, edge, dt);
      });
    });
    if (10 * (sleepers_.report.asleep + static_cast<std::int64_t>(tired_.size())) < sleepers_.free) {
      if (sleepers_.report.asleep > 0)
        for (Index i = 0; i < state.size(); ++i)
          if (sleepers_[i].is_asleep()) sleepers_.wake(i, Kind::watched);
      return;
    }
    for (const std::int32_t i : tired_) sleepers_.fall_asleep(state, i);
  }
  /// Makes the lists and the active set of who is awake, watched, asleep.
  void part(S& state) {
    put_off_ = true;  // until it is done
    watched_.clear(), flags_.assign(sleepers_.all.size(), std::uint8_t{0});
    supports_move_ = false;
    for (Index i = 0; i < state.size(); ++i) {
      Sleeper& one = sleepers_[i];
      if (one.kind == Kind::watched) watched_.push_back(static_cast<std::int32_t>(i));
      if (one.kind == Kind::held) {
        one.moves = (state.v.col(i).array() != 0).any();
        if constexpr (spins) one.moves = one.moves || (state.omega.col(i).array() != 0).any();
        supports_move_ = supports_move_ || one.moves;
      }
      flags_[static_cast<std::size_t>(i)] = one.kind == Kind::awake || one.kind == Kind::watched ? 1 : 0;
    }
    sleepers_.count();
    find_frontier(state);
    if (sleepers_.report.asleep == 0) {
      stepper_.set_active(nullptr);
    } else {
      const std::shared_ptr<ActiveSet> active = sets_.take();
      active->assign(flags_, next_body_serial());
      stepper_.set_active(active);
    }
    sleepers_.changed = put_off_ = false;
    if (!is_all_asleep()) return;
    fell_asleep_as_.remember(Scalar{0}, state);
    bodies_ = bits_of(state.body());
  }
  /// Pairs of somebody awake with a sleeper.
  void find_frontier(const S& state) {
    frontier_.clear();
    if (sleepers_.report.asleep == 0 || !graph_.is_of(state.size())) return;
    for (Index i = 0; i < state.size(); ++i) {
      if (!sleepers_[i].disturbs()) continue;
      for (const TouchGraph::Edge& edge : graph_.of(i))
        if (sleepers_[edge.other].is_asleep()) frontier_.push_back({static_cast<std::int32_t>(i), edge});
    }
  }

  Stepper stepper_;
  Sleepers<S> sleepers_;
  TouchGraph graph_;
  struct Meeting {
    std::int32_t mover;
    TouchGraph::Edge edge;
  };
  std::vector<Meeting> frontier_;
  std::vector<std::int32_t> watched_, tired_;
  std::vector<std::uint8_t> flags_;
  Recycled<ActiveSet> sets_;
  std::uint64_t body_ = 0, scene_ = 0;
  EditGuard<S, false, false> fell_asleep_as_;  // and with these …
  std::uint64_t bodies_ = 0;                   // … properties
  std::int64_t steps_ = 0, pair_changes_ = 0, changes_ = 0;
  bool put_off_ = false;
  bool supports_move_ = false;
};

}  // namespace phistep::inline PHISTEP_ABI
