/// @file
/// Several steppers of one problem, of which one exists at a time: every call goes to that one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <variant>

#include "phistep/base/archive/archive_kinds.hpp"
#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/outcome/step_report.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/run/errors/step_filter.hpp"
#include "phistep/run/stepper/any_stepper.hpp"
#include "phistep/step/equation/origin.hpp"
#include "phistep/step/transaction/trace.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A std::variant of steppers of one state, as a stepper.
template <class S, class... Stepper>
class ActiveStepper {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using StateType = S;
  using Steppers = std::variant<Stepper...>;
  /// The checkpoint of the stepper at work.
  using Checkpoint = std::variant<typename Stepper::Checkpoint...>;
  using ArchivedByParts = void;
  static constexpr const char* part_name = "stepper";

  /// @param make  make() → Steppers that hold the first one to be at work: in place, not moved
  template <class Make>
    requires std::is_invocable_r_v<Steppers, const Make&>
  explicit ActiveStepper(const Make& make) : steppers_(make()) {}

  /// The number of the stepper at work.
  [[nodiscard]] int active() const { return static_cast<int>(steppers_.index()); }
  /// Another one takes over; but for the sizes of a run before, what the last one knew is lost.
  void replace(Steppers next) {
    if constexpr (!FieldState<S>)
      visit_numbered(
          next, [this](auto, auto& stepper) { StepperInternals::kept_sizes(stepper) = std::move(kept_sizes(*this)); });
    visit_numbered(next,
                   [this](auto number, auto& stepper) { steppers_.template emplace<number>(std::move(stepper)); });
  }

  /// A step at a given Δt. [time]
  StepReport step(S& state, Scalar t, Scalar dt, Origin origin = Origin::unknown) {
    return visit(*this, [&](auto& at_work) { return at_work.step(state, t, dt, origin); });
  }
  // What a run controlled by its error asks beside steps: what the stepper at work can tell.
  static constexpr StepperFacts facts{.traces = true,
                                      .interpolates = true,
                                      .is_sure_inside = false,
                                      .solves_nothing = false,
                                      .reads_weights = true,
                                      .refactorizes = false,
                                      .is_affine = false,
                                      .takes_several = false,
                                      .has_inner_steps = false,
                                      .doubtful_at = usually_doubtful};
  [[nodiscard]] bool estimates(const Trace<Plain>& trace) const {
    return visit(*this, [&](auto& at_work) { return at_work.estimates(trace); });
  }
  StepReport attempt(S& state, Scalar t, Scalar dt, Origin origin, Trace<Plain>& trace, const Judge<Plain>& accept) {
    return visit(*this, [&](auto& at_work) { return at_work.attempt(state, t, dt, origin, trace, accept); });
  }
  [[nodiscard]] ErrorLaw law() const {
    return visit(*this, [](auto& at_work) { return error_law(at_work); });
  }
  [[nodiscard]] int order() const {
    return visit(*this, [](auto& at_work) { return at_work.order(); });
  }
  /// out = y' at (t, y): one force call; false where it isn't finite.
  [[nodiscard]] bool slope(Scalar t, const Plain& y, Plain& out) {
    return visit(*this, [&](auto& at_work) { return at_work.slope(t, y, out); });
  }
  [[nodiscard]] const SolveRecord& last_solve() const {
    return visit(*this, [](auto& at_work) -> const SolveRecord& { return at_work.last_solve(); });
  }
  [[nodiscard]] Statistics statistics() const {
    return visit(*this, [](auto& at_work) -> Statistics { return at_work.statistics(); });
  }
  [[nodiscard]] std::int64_t changes() const {
    return visit(*this, [](auto& at_work) { return at_work.changes(); });
  }
  [[nodiscard]] Checkpoint checkpoint() const {
    return visit_numbered(steppers_, [](auto number, auto& at_work) {
      return Checkpoint{std::in_place_index<number>, at_work.checkpoint()};
    });
  }
  /// To a point that another stepper may have known: then this one has nothing from there.
  void restore(Checkpoint checkpoint) {
    visit_numbered(steppers_, [&](auto number, auto& at_work) {
      if (auto* const past = std::get_if<number>(&checkpoint)) at_work.restore(std::move(*past));
      else at_work.reset();
    });
  }
  void forget_unsaved() {
    visit(*this, []<class AtWork>(AtWork& at_work) {
      if constexpr (HasUnsaved<AtWork>) at_work.forget_unsaved();
    });
  }
  void archive(auto& ar) {
    visit(*this, [&ar](auto& at_work) { at_work.archive(ar); });
  }

 private:
  friend StepperInternals;

  /// f(std::integral_constant<std::size_t, number>, the stepper of that number, which is at work)
  template <std::size_t i = 0>
  [[gnu::always_inline]] static inline decltype(auto) visit_numbered(auto& steppers, auto&& f) {
    if constexpr (i + 1 < sizeof...(Stepper))
      if (steppers.index() != i) return visit_numbered<i + 1>(steppers, f);
    return f(std::integral_constant<std::size_t, i>{}, *std::get_if<i>(&steppers));
  }
  /// f(the stepper at work)
  [[gnu::always_inline]] static inline decltype(auto) visit(auto& self, auto&& f) {
    return visit_numbered(self.steppers_, [&f](auto, auto& at_work) -> decltype(auto) { return f(at_work); });
  }

  Steppers steppers_;
};

}}  // namespace phistep::PHISTEP_ABI
