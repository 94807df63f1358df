/// @file
/// Something that happens when a function of the state passes zero: a bounce, a switch, the end of a run.
///
/// The handler finds the state on the root, up to rounding, and may edit it. What it leaves there at rest passes through:
/// a ball that is stopped on the ground, with gravity on, falls on. Let the handler end such a run, or change the force.
///
/// Which roots are found. A step knows g at its start and at its end.
/// - Signs that differ: one root between them is found. Of three or more, any of them, and those before it are passed over;
///   the run goes on from the one found, and sees the others if they are not one step's again.
/// - Equal signs: with `inside` (the default) g is asked a little inside of both ends. If |g| falls at the start and climbs
///   at the end, its turning point is sought, and if g has the other sign there, the first of the two roots is found (in the
///   wanted direction: else the second). Any other even number of roots, and two between ends where |g| doesn't turn so, are
///   passed over. Without `inside`, all of them are.
/// Where roots may lie nearer to each other than steps are long, keep steps shorter: max_step of a tolerance, or at_times.
#pragma once

#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/run/observers/completed_step.hpp"
#include "phistep/run/observers/root.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Which roots of g count, and what they do.
struct EventOptions {
  Direction direction = Direction::both;  ///< which way g passes zero, as the run goes
  bool terminal = false;                  ///< the first one ends the run
  /// Finds g that passes zero and comes back within one step, once: one or two more evaluations of g a step, at the
  /// price of the interpolant's slopes.
  bool inside = true;
};

struct NoHandler {};

/// What `event(g, …)` returns.
template <class G, class Handler = NoHandler>
class Event {
 public:
  using IsEvent = void;
  using ArchivedByParts = void;

  Event(G function, const EventOptions& options, Handler handler)
      : g_(std::move(function)), handler_(std::move(handler)), options_{options} {}

  /// g(t, state) or g(state), as `Scalar`.
  template <class Scalar, class Plain>
  [[nodiscard]] Scalar value(Scalar t, const Plain& y) {
    constexpr bool timed = std::is_invocable_v<G&, Scalar, const Plain&>;
    constexpr bool plain = std::is_invocable_v<G&, const Plain&>;
    static_assert(timed || plain, "phistep: the function of an event must be callable as g(state) or g(t, state)");
    if constexpr (timed) return number<Scalar>(g_(t, y));
    else if constexpr (plain) return number<Scalar>(g_(y));
    else return Scalar{};
  }
  /// It has happened. False where the run is to end.
  template <class Scalar, class S>
  [[nodiscard]] bool happened(Scalar t, S& state) {
    times_.push_back(static_cast<double>(t));
    if constexpr (std::is_same_v<Handler, NoHandler>) return !options_.terminal;
    else return goes_on(handler_, t, state) && !options_.terminal;
  }
  /// A run starts at t. Whether the event happened just there, in a run before: then it is not to happen again.
  bool begin(double t) {
    if (!times_.empty()) last_ = times_.back();
    times_.clear();
    return last_ == t;
  }
  /// It may happen now: room to note it, so that no handler is missed for want of memory.
  void prepare() {
    if (times_.size() == times_.capacity()) times_.reserve(2 * times_.size() + 8);
  }

  [[nodiscard]] const EventOptions& options() const { return options_; }
  /// When it happened in the last run. [time]
  [[nodiscard]] const std::vector<double>& times() const { return times_; }

  /// Its times, for a checkpoint.
  void archive(auto& ar) { ar("times", times_); }

 private:
  template <class Scalar, class Value>
  [[nodiscard]] static Scalar number(const Value& g) {
    static_assert(
        std::is_convertible_v<Value, Scalar> && !std::is_same_v<Value, bool>,
        "phistep: the function of an event must return a number that changes its sign there (a bool doesn't)");
    return static_cast<Scalar>(g);
  }

  G g_;
  [[no_unique_address]] Handler handler_;
  EventOptions options_;
  std::vector<double> times_;
  double last_ = std::numeric_limits<double>::quiet_NaN();  // [time] in the runs before
};

template <class T>
concept EventLike = requires {
  typename std::remove_cvref_t<T>::IsEvent;
};

/// `integrate(…, event([](const auto& y) { return y.r.z(); }, {.direction = Direction::falling}, bounce))`
/// @param function  g(state) or g(t, state) → a number; of a Map's state it sees the owning twin
/// @param handler   called as handler(t, state) when g passes zero; it may edit the state, and return false to end the run
template <class G, class Handler = NoHandler>
[[nodiscard]] Event<G, Handler> event(G function, EventOptions options = {}, Handler handler = {}) {
  return {std::move(function), options, std::move(handler)};
}
/// An event with default options, both ways and not terminal: `event(g, handler)`.
template <class G, class Handler>
  requires(!std::is_convertible_v<Handler, EventOptions>)
[[nodiscard]] Event<G, Handler> event(G function, Handler handler) {
  return {std::move(function), EventOptions{}, std::move(handler)};
}

}}  // namespace phistep::PHISTEP_ABI
