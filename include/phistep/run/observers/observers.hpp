/// @file
/// The observers of a run, as one, and how it asks each.
#pragma once

#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/archive/archive.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/embed/number_parts.hpp"
#include "phistep/run/observers/completed_step.hpp"
#include "phistep/run/observers/event.hpp"
#include "phistep/run/observers/event_set.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// An observer of whole steps.
template <class Observer, class S>
inline constexpr bool observes_steps = std::is_invocable_v<Observer&, const CompletedStep<S>&>;

/// @tparam Observers  references where they were given as lvalues
template <State S, class... Observers>
class ObserverList {
  template <class Observer>
  static constexpr bool sees_steps = EventLike<Observer> || observes_steps<Observer, S>;
  template <class Observer>
  static constexpr bool looks_at_ends_alone = requires {
    requires Observer::looks_at_ends_alone;
  };

 public:
  using Scalar = ScalarOf<S>;
  static_assert(((!EventLike<Observers> || !std::is_const_v<std::remove_reference_t<Observers>>)&&...),
                "phistep: an event keeps the times at which it occurred, so it can't be const");

  static_assert(
      !(EventLike<Observers> || ...) || may_have_events<S>,
      "phistep: an event's time depends on what numbers with derivatives are differentiated by, and its derivative "
      "is not computed: without events, or by differences of two runs");

  explicit ObserverList(Observers&&... observers) : observers_{std::forward<Observers>(observers)...} {}

  static constexpr bool has_events = (EventLike<Observers> || ...);
  /// Whether at least one observer is shown whole steps.
  static constexpr bool see_steps = (sees_steps<std::remove_reference_t<Observers>> || ...);
  /// Whether an observer of whole steps may ask for states inside them.
  static constexpr bool may_look_inside =
      ((sees_steps<std::remove_reference_t<Observers>> && !looks_at_ends_alone<std::remove_reference_t<Observers>>) ||
       ...);

  /// Before the first step. False where one asks for the end of the run.
  [[nodiscard]] bool begin(Scalar t, S& state) {
    const auto greet = [&]<class Observer>(Observer& observer) {
      if constexpr (requires { observer.begin(t, state); }) {
        const auto begin = [&] { return observer.begin(t, state); };
        if (!ask_all_ranks(state, [&] { return call_and_ask(begin); })) return false;
      }
      return show_to(observer, t, state);
    };
    return std::apply([&](auto&... observer) { return (greet(observer) && ...); }, observers_);
  }
  /// After a step: observers of whole steps first, as the others may edit the state. False where one asks for the
  /// end of the run.
  [[nodiscard]] bool look(Scalar t, S& state, [[maybe_unused]] const auto& step) {
    const auto show_step = [&]<class Observer>(Observer& observer) {
      if constexpr (sees_steps<Observer> && !EventLike<Observer>)
        return ask_all_ranks(state, [&] { return call_and_ask(observer, step); });
      else return true;
    };
    return std::apply(
        [&](auto&... observer) { return (show_step(observer) && ...) && (show_to(observer, t, state) && ...); },
        observers_);
  }
  /// The nearest of all times at which one wants the run to stop, strictly between now and its end. [time]
  [[nodiscard]] std::optional<Scalar> next_stop(Scalar t, Scalar end) const {
    const Scalar sign = end < t ? Scalar{-1} : Scalar{1};
    std::optional<Scalar> nearest;
    const auto consider = [&](const auto& observer) {
      if constexpr (requires { observer.next_stop(t, sign); }) {
        const std::optional<Scalar> stop = observer.next_stop(t, sign);
        if (stop && sign * (*stop - t) > 0 && sign * (end - *stop) > 0 && (!nearest || sign * (*nearest - *stop) > 0))
          nearest = stop;
      }
    };
    std::apply([&](const auto&... observer) { (consider(observer), ...); }, observers_);
    return nearest;
  }
  /// The events, tied.
  [[nodiscard]] auto events() {
    return tied(*this, []<class Observer>() { return EventLike<Observer>; });
  }
  /// Those that a checkpoint holds, tied.
  [[nodiscard]] static auto kept(auto& list) {
    return tied(list, []<class Observer>() { return detail::Archived<std::remove_const_t<Observer>>; });
  }

 private:
  /// Shows (t, state) to one that takes these.
  template <class Observer>
  [[nodiscard]] static bool show_to(Observer& observer, Scalar t, S& state) {
    static_assert(!std::is_const_v<Observer> || sees_steps<Observer> || std::is_invocable_v<Observer&, Scalar, S&>,
                  "phistep: this observer changes as it observes, so it can't be const");
    static_assert(
        std::is_const_v<Observer> || sees_steps<Observer> || std::is_invocable_v<Observer&, Scalar, S&>,
        "phistep: an observer must be callable as observer(t, state) or observer(step), returning nothing or false "
        "to stop");
    if constexpr (sees_steps<Observer>) return true;
    else if constexpr (!std::is_invocable_v<Observer&, Scalar, S&>) return false;
    else return ask_all_ranks(state, [&] { return call_and_ask(observer, t, state); });
  }
  template <class IsMeant>
  [[nodiscard]] static auto tied(auto& list, IsMeant) {
    const auto tie = []<class Observer>(Observer& observer) {
      if constexpr (IsMeant{}.template operator()<Observer>()) return std::tie(observer);
      else return std::tuple<>{};
    };
    return std::apply([&](auto&... observer) { return std::tuple_cat(tie(observer)...); }, list.observers_);
  }

  std::tuple<Observers...> observers_;
};

}}  // namespace phistep::PHISTEP_ABI
