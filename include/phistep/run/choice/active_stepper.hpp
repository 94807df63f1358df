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
#include "phistep/base/version.hpp"
#include "phistep/run/control/error_law.hpp"
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
  /// Of the stepper at work.
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
      visit_numbered(next, [this](auto, auto& stepper) { stepper.kept_sizes() = std::move(kept_sizes()); });
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
                                      .doubtful_at = usually_doubtful};
  [[nodiscard]] bool estimates(const Trace<Plain>& trace) const {
    return visit(*this, [&](auto& at_work) { return at_work.estimates(trace); });
  }
  template <class Accept>
  StepReport attempt(S& state, Scalar t, Scalar dt, Origin origin, Trace<Plain>& trace, Accept&& accept) {
    return visit(*this, [&](auto& at_work) { return at_work.attempt(state, t, dt, origin, trace, accept); });
  }
  /// As PhiStepper's; false, too, where the scheme at work has no interpolant of its own.
  [[nodiscard]] bool know_inside(Scalar dt, const Plain& y0) {
    return visit(*this, [&]<class AtWork>(AtWork& at_work) {
      if constexpr (facts_of<AtWork>.interpolates) return at_work.know_inside(dt, y0);
      else return false;
    });
  }
  void interpolate(Scalar x, Scalar dt, const Plain& y0, const Plain& y1, Plain& out) const {
    visit(*this, [&]<class AtWork>(AtWork& at_work) {
      if constexpr (facts_of<AtWork>.interpolates) at_work.interpolate(x, dt, y0, y1, out);
    });
  }
  [[nodiscard]] bool is_sure_inside() const {
    return visit(*this, []<class AtWork>(AtWork&) -> bool { return facts_of<AtWork>.is_sure_inside; });
  }
  [[nodiscard]] bool is_explicit() const {
    return visit(*this, []<class AtWork>(AtWork&) -> bool { return facts_of<AtWork>.solves_nothing; });
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
  void complete_slopes(const Plain& y0, const Plain& y1, Scalar dt, Plain& slope0, Plain& slope1) const {
    visit(*this, [&](auto& at_work) { at_work.complete_slopes(y0, y1, dt, slope0, slope1); });
  }
  [[nodiscard]] const SolveRecord& last_solve() const {
    return visit(*this, [](auto& at_work) -> const SolveRecord& { return at_work.last_solve(); });
  }
  [[nodiscard]] const char* solver_name() const {
    return visit(*this, [](auto& at_work) { return at_work.solver_name(); });
  }
  [[nodiscard]] Statistics statistics() const {
    return visit(*this, [](auto& at_work) -> Statistics { return at_work.statistics(); });
  }
  [[nodiscard]] std::int64_t changes() const {
    return visit(*this, [](auto& at_work) { return at_work.changes(); });
  }
  /// The force of the stepper at work, to be called and not to be changed.
  [[nodiscard]] auto& force_to_look_at() {
    return visit(
        *this, [](auto& at_work) -> auto& { return at_work.force_to_look_at(); });
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
  void forget_solves() {
    visit(*this, [](auto& at_work) { at_work.forget_solves(); });
  }
  void forget_unsaved() {
    visit(*this, []<class AtWork>(AtWork& at_work) {
      if constexpr (HasUnsaved<AtWork>) at_work.forget_unsaved();
    });
  }
  /// Forgets all that is carried from step to step; the same stepper stays at work.
  void reset() {
    visit(*this, [](auto& at_work) { at_work.reset(); });
  }
  [[nodiscard]] auto& kept_sizes() requires(!FieldState<S>) {
    return visit(
        *this, [](auto& at_work) -> auto& { return at_work.kept_sizes(); });
  }
  void archive(auto& ar) {
    visit(*this, [&ar](auto& at_work) { at_work.archive(ar); });
  }

 private:
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
