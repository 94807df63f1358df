/// @file
/// A step that has become the state, as an observer sees it: both ends, its length, and what lies between.
#pragma once

#include <type_traits>
#include <utility>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/step/equation/origin.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// f(args…); true where f returns nothing, or something true.
template <class F, class... Args>
[[nodiscard]] bool call_and_ask(F& f, Args&&... args) {
  if constexpr (std::is_void_v<std::invoke_result_t<F&, Args...>>) {
    f(std::forward<Args>(args)...);
    return true;
  } else {
    return static_cast<bool>(f(std::forward<Args>(args)...));
  }
}

/// The same for f(t, state), with a readable error.
template <class F, class Scalar, class S>
[[nodiscard]] bool goes_on(F& f, Scalar t, S& state) {
  static_assert(std::is_invocable_v<F&, Scalar, S&>,
                "phistep: this must be callable as f(t, state), returning nothing or false to end the run");
  if constexpr (!std::is_invocable_v<F&, Scalar, S&>) return false;
  else return call_and_ask(f, t, state);
}

/// Handed to observers that take one argument: `integrate(…, [](const auto& step) { … step.at(t) … })`. Valid during the
/// call.
/// @tparam has_inside  the stepper can be copied, as states inside its steps need
template <State S, bool has_inside = true>
class CompletedStep {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;

  /// @param inside  inside.at(t) is the state in between: a DenseOutput, or a run's LookInside
  /// @param middle  the state at t0 + dt/2, where the step was done as two halves
  /// @param times   at which the step asked its force
  /// @param state   the run's
  template <class Inside>
  CompletedStep(Scalar t0, Scalar dt, Scalar t1, const Plain& start, const Plain& end, Inside& inside,
                const Plain* middle = nullptr, const Times<Scalar>& times = {}, S* state = nullptr)
      : t0_{t0},
        dt_{dt},
        t1_{t1},
        start_{start},
        end_{end},
        inside_{&inside},
        middle_{middle},
        times_{times},
        state_{state} {
    at_ = [](void* self, Scalar t) -> const Plain& { return static_cast<Inside*>(self)->at(t); };
  }

  [[nodiscard]] Scalar t0() const { return t0_; }  ///< [time]
  [[nodiscard]] Scalar t1() const { return t1_; }  ///< [time]
  [[nodiscard]] Scalar dt() const { return dt_; }  ///< [time] nominal: t1 − t0 differs in its last bits
  [[nodiscard]] decltype(auto) start() const { return shown<S>(start_); }  ///< the state at t0, after all edits
  [[nodiscard]] decltype(auto) end() const { return shown<S>(end_); }      ///< the state at t1, before any edit
  /// The state at t0 ≤ t ≤ t1, to the accuracy of the step: interpolated where that is known to be as good, else by a step
  /// really done from t0 to t, which the run doesn't notice. Valid until the next call.
  [[nodiscard]] decltype(auto) at(Scalar t) const {
    static_assert(
        has_inside,
        "phistep: to look inside its steps, a stepper must be copyable: give it the force as std::ref(force)");
    return shown<S>(t == t1_ ? end_ : at_(inside_, t));
  }
  /// f(t, the state at t), and whether the run goes on. Of a state in a code's own arrays f may read those: it is there for
  /// the call.
  [[nodiscard]] bool show(Scalar t, auto& f) const {
    const auto& y = at(t);
    if constexpr (ShowsTrials<S>) {
      state_->hold();
      const AtExit back{[this] {
        state_->put_back();
        state_->release();
      }};
      copy_blocks<S>(*state_, y);
      return goes_on(f, t, std::as_const(*state_));
    } else {
      return goes_on(f, t, y);
    }
  }
  /// The state at t0 + dt/2 where two steps of half the length led from start to end, else null.
  [[nodiscard]] const Plain* middle() const { return middle_; }
  /// t, or the time next to it inside the step where the force may jump there. [time]
  [[nodiscard]] Scalar inside(Scalar t) const { return times_(t); }

 private:
  Scalar t0_, dt_, t1_;
  const Plain& start_;
  const Plain& end_;
  void* inside_;
  const Plain& (*at_)(void*, Scalar);
  const Plain* middle_;
  Times<Scalar> times_;
  S* state_;
};

}}  // namespace phistep::PHISTEP_ABI
