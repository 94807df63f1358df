/// @file
/// All events of a run: which comes first in a step, and which happen with it.
///
///     events.begin(t, state)                  the run starts
///     found = events.find(step)               after each step: one evaluation of every g, at its end; more, and the
///                                             interpolant, only where there may be something to see
///     hit = events.refine(found, restep)      restep(t) steps anew from t0 to t → the state there, null where that failed;
///                                             hit.resteps = 0: the event is the end of the step, which stands
///     events.look(found, hit.t, state)        which others happen with it
///     events.happen(hit.t, state)             handlers, which may edit the state
///     events.rearm(t, state)                  after edits by others: a sign that an edit changes is no event
///
/// What returns an Outcome says how the run goes on: success, non_finite_event, stopped_by_event, events_accumulate.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/run/control/run_clock.hpp"
#include "phistep/run/observers/completed_step.hpp"
#include "phistep/run/observers/event.hpp"
#include "phistep/run/observers/root.hpp"
#include "phistep/step/equation/origin.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What an event remembers between steps.
template <class Scalar>
struct Armed {
  /// Its crossings in one direction.
  struct Crossings {
    Scalar last{};      ///< [time] of the last, or when the run began
    Scalar interval{};  ///< [time] between the last two of these
    bool any = false;   ///< in this run

    void archive(auto& ar) { ar("last", last, "interval", interval, "any", any); }
  };
  Scalar g{};  ///< where the run stands
  Crossings rising, falling;
  Standing standing = Standing::unknown;

  void archive(auto& ar) {
    ar("g", g, "rising", rising, "falling", falling, "standing", standing);
    ar.check(standing <= Standing::unknown);
  }
};

/// @tparam Events  models of EventLike, held by reference
template <State S, EventLike... Events>
class EventSet {
 public:
  using ArchivedByParts = void;
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  static constexpr std::size_t size = sizeof...(Events);

  /// The first event of a step, or the first time at which a g is not finite.
  struct Found {
    Outcome outcome = Outcome::success;  ///< or non_finite_event
    std::size_t which = size;            ///< in the order given
    Root<Scalar> root;
    /// Whether there is an event.
    [[nodiscard]] explicit operator bool() const { return root.kind == Root<Scalar>::Kind::found; }
  };

  explicit EventSet(Events&... events) : events_{events...} {}
  explicit EventSet(const std::tuple<Events&...>& events) : events_{events} {}

  [[nodiscard]] Outcome begin(Scalar t, const S& state) {
    each([&](auto k, auto& event) {
      memory_[k] = {.rising = {.last = t}, .falling = {.last = t}};
      if (event.begin(static_cast<double>(t))) memory_[k].standing = Standing::on_root;
    });
    return rearm(t, state);
  }

  [[nodiscard]] Outcome rearm(Scalar t, const S& state) {
    const Plain& y = gathered<S>(state, plain_);
    bool finite = true;
    each([&](auto k, auto& event) {
      memory_[k].g = value_of(event, t, y);
      finite = finite && std::isfinite(memory_[k].g);
    });
    return finite ? Outcome::success : Outcome::non_finite_event;
  }

  [[nodiscard]] Found find(const CompletedStep<S>& step) {
    Found first;
    step_ = step.dt();
    each([&](auto k, auto& event) {
      event.prepare();
      const auto value = [&](Scalar t) { return value_of(event, t, step.at(t)); };
      const EventOptions& options = event.options();
      end_[k] = {step.t1(), value_of(event, step.t1(), step.end())};
      const Root<Scalar>& root = roots_[k] = first_root(Sample<Scalar>{step.t0(), memory_[k].g}, end_[k], value,
                                                        memory_[k].standing, options.direction, options.inside);
      using Kind = typename Root<Scalar>::Kind;
      if (root.kind == Kind::none) return;
      if (first.which < size && !is_before(root.t, first.root.t, step.dt())) return;
      first.outcome = root.kind == Kind::not_finite ? Outcome::non_finite_event : Outcome::success;
      first.which = k;
      first.root = root;
    });
    if (first.which == size)
      each([this](auto k, auto&) {
        if (roots_[k].start_sign != 0) memory_[k].standing = Standing::clear;
        memory_[k].g = end_[k].g;
      });
    return first;
  }

  template <class Restep>
  [[nodiscard]] Refined<Scalar> refine(const Found& found, Restep&& restep) {
    Refined<Scalar> hit{};
    each([&](auto k, auto& event) {
      if (k != found.which) return;
      hit = phistep::refine(found.root, end_[k], [&](Scalar t) {
        const Plain* y = restep(t);
        return y == nullptr ? std::numeric_limits<Scalar>::quiet_NaN() : value_of(event, t, *y);
      });
      at_root_[k] = hit.g;
    });
    return hit;
  }

  /// Which events happen with the one found: whose own root is that one as far as time can tell, or whose g has passed zero in the
  /// step done again. Asks every g and changes nothing: where one throws, the step can still be taken back.
  void look(const Found& found, Scalar t, const S& state) {
    const Plain& y = gathered<S>(state, plain_);
    each([&](auto k, auto& event) {
      const Root<Scalar>& root = roots_[k];
      known_[k] = root.start_sign != 0 && !is_before(t, root.start, end_[k].t - root.start);
      const bool together = root.kind == Root<Scalar>::Kind::found &&
                            std::abs(root.t - found.root.t) <= root.tolerance + found.root.tolerance;
      happens_[k] = k == found.which;
      if (happens_[k] || !(together || known_[k])) return;
      const Scalar g = value_of(event, t, y);
      happens_[k] = together || passed(root.start_sign, g, event);
      if (happens_[k]) at_root_[k] = g;
    });
  }
  /// Calls the handlers of these, in the order given.
  [[nodiscard]] Outcome happen(Scalar t, S& state) {
    each([&](auto k, auto&) {
      if (happens_[k]) memory_[k].standing = Standing::on_root;
      else if (known_[k]) memory_[k].standing = Standing::clear;
    });
    bool goes_on = true, accumulate = false;
    each([&](auto k, auto& event) {
      goes_on = (!happens_[k] || ask_all_ranks(state, [&] { return event.happened(t, state); })) && goes_on;
    });
    const Outcome outcome = rearm(t, state);
    each([&](auto k, auto&) {
      if (!happens_[k]) return;
      const Root<Scalar>& root = roots_[k];
      // What a handler has led away from its root has a sign again.
      const Scalar rounding = std::abs(at_root_[k]) + std::abs(root.slope) * root.tolerance;
      const bool leaves = std::abs(memory_[k].g) > 8 * rounding && root.tolerance > 0;
      if (leaves) memory_[k].standing = Standing::clear;
      const Scalar shortest = (leaves || is_short(t, step_) ? 4 : 32) * first_probe(t, step_);
      accumulate = note(root.start_sign < 0 ? memory_[k].rising : memory_[k].falling, t, shortest) || accumulate;
    });
    if (!goes_on) return Outcome::stopped_by_event;
    return outcome == Outcome::success && accumulate ? Outcome::events_accumulate : outcome;
  }

  /// Ends the step that led to `to` at its first event, if one is found: it is done again, shorter, and is then a step like any other,
  /// of the same scheme and with the same error test, which may refuse it. Then `to` is where that is.
  /// @param step    a StepAttempt, done   @param inside  a LookInside of it
  /// @param first   the first event; the run ends if its outcome is not success
  /// @return the step's; unless it is a success, or where the run ends, or g or the force throws, all is as at its start
  [[nodiscard]] StepReport cut(auto& step, auto& inside, Landing<Scalar>& to, Found& first) {
    try {
      inside.begin(to.dt);
      const CompletedStep<S> whole{step.t0(), to.dt, step.clock().t(), step.start(), step.plain(), inside};
      first = find(whole);
      // Where the interpolant is far off, it may have roots of its own: then the search is done by real steps.
      if ((first || failed(first.outcome)) && first.root.t != whole.t1() && inside.was_off()) first = find(whole);
      StepReport done{Outcome::success, 0, nullptr};
      if (first) done = go_to(first, to, step, inside);
      if (!done) return done;
      if (first) look(first, step.clock().t(), step.state());
      // Where g passes zero inside the step, slopes that are none say so.
      if (!failed(first.outcome)) first.outcome = inside.outcome();
      if (failed(first.outcome)) step.undo();
      return done;
    } catch (...) {
      step.undo_for_good();
      throw;
    }
  }

  /// What is remembered between steps.
  void archive(auto& ar) { ar("events", memory_); }

 private:
  /// Does the step again, up to the event.
  [[nodiscard]] StepReport go_to(Found& found, Landing<Scalar>& to, auto& step, auto& inside) {
    StepReport done{Outcome::success, 0, nullptr};
    Landing<Scalar> shorter = to;
    const auto hit = refine(found, [&](Scalar t) -> const Plain* {
      step.undo();
      shorter = to;
      if (t != to.end || !to.lands) shorter = {.end = t, .dt = step.length_to(t), .lands = true, .clipped = true};
      shorter.at_stop = true;
      done = step.attempt(shorter, Origin::unknown, false);
      return done ? &step.plain() : nullptr;
    });
    if (done && hit.resteps > 0) inside.begin_again(shorter.dt);
    if (done && !std::isfinite(hit.g)) found.outcome = Outcome::non_finite_event;
    if (hit.resteps > 0) to = shorter;
    to.at_stop = true;
    if (!done) step.undo();
    return done;
  }
  template <class F>
  void each(F&& f) {
    [&]<std::size_t... K>(std::index_sequence<K...>) {
      (f(std::integral_constant<std::size_t, K>{}, std::get<K>(events_)), ...);
    }
    (std::make_index_sequence<size>{});
  }
  [[nodiscard]] static Scalar value_of(auto& event, Scalar t, const auto& y) {
    if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(y)>, Plain>) return event.value(t, y);
    else return same_on_ranks(y, [&] { return event.value(t, shown<S>(y)); });
  }
  /// g has passed zero, or stands there: the next step would find no sign to come from.
  [[nodiscard]] static bool passed(int from, Scalar g, const auto& event) {
    const Direction wanted = event.options().direction;
    return sign_of(g) != from && (wanted == Direction::both || static_cast<int>(wanted) == -from);
  }
  /// Notes a crossing at t. True where the search may miss one soon: if the intervals go on shrinking as they did, the
  /// one after next is shorter than that. (What rounding left of g at this event, seen in time, grows by that ratio.)
  /// Intervals are those between crossings in one direction: a g that grazes zero crosses it to and fro within a short
  /// time, and then not for long.
  [[nodiscard]] static bool note(typename Armed<Scalar>::Crossings& crossings, Scalar t, Scalar shortest) {
    const Scalar now = std::abs(t - crossings.last), before = crossings.interval;
    crossings.last = t;
    crossings.interval = now;
    if (!std::exchange(crossings.any, true)) return false;
    const Scalar ratio = before > now ? now / before : Scalar{1};
    return now * ratio * ratio <= shortest;
  }

  std::tuple<Events&...> events_;
  std::array<Armed<Scalar>, size> memory_{};
  Scalar step_{};                       // [time] the step searched last
  std::array<Scalar, size> at_root_{};  // g after the step to an event, before its handlers
  std::array<Sample<Scalar>, size> end_{};
  std::array<Root<Scalar>, size> roots_{};
  std::array<bool, size> happens_{}, known_{};
  [[no_unique_address]] Only<!std::is_same_v<S, Plain>, Plain> plain_;
};

template <State S, class... Events>
EventSet<S, Events...> set_of(std::tuple<Events&...>);  // a type alone

}}  // namespace phistep::PHISTEP_ABI
