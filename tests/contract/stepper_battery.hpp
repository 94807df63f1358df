#pragma once

// The contract of a stepper: what it does to a state where its force misbehaves or its arguments can't work.

#include <phistep/phistep.hpp>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "contract/states.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

namespace states {

using namespace phistep;

enum class Trouble { none, nan, inf, exception };

/// Does as it is told.
struct Moody {
  const Trouble* mood;
  auto operator()(const auto& r) const {
    auto f = Pull{}(r);
    if (*mood == Trouble::exception) throw std::runtime_error("moody");
    if (*mood == Trouble::nan) component(f, 4) = std::nan("");
    if (*mood == Trouble::inf) component(f, 4) = -HUGE_VAL;
    return f;
  }
};

template <class Stepper>
constexpr bool is_halving = false;
template <class Stepper>
constexpr bool is_halving<Halving<Stepper>> = true;

/// A stepper with its state, whatever their types: the checks below are compiled once, not for each.
struct Subject {
  Subject() = default;
  Subject(const Subject&) = delete;
  virtual ~Subject() = default;
  [[nodiscard]] virtual bool drifts() const = 0;
  [[nodiscard]] virtual bool halves() const = 0;
  [[nodiscard]] virtual bool traces() const = 0;
  [[nodiscard]] virtual int order() const = 0;
  virtual StepReport step(double t, double dt) = 0;
  virtual void reset() = 0;
  [[nodiscard]] virtual Statistics statistics() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd numbers() const = 0;
  // Of watched ones only.
  virtual StepReport attempt(double t, double dt, bool accept) = 0;
  virtual void forget() = 0;
  virtual void edit() = 0;
  const char* name = "";  ///< of the scheme, printed where a check fails
};

/// The PhiStepper itself; else a functor that wraps it.
struct AsItIs {};

/// @tparam watched  whether attempt() is compiled
template <class Case, class Force, class Scheme, class Wrap, bool watched>
class Body final : public Subject {
  using S = typename Case::State;
  static auto make(const S& state, const Force& force, const Scheme& scheme) {
    if constexpr (std::is_same_v<Wrap, AsItIs>) return PhiStepper{state, force, scheme};
    else return Wrap{}(PhiStepper{state, force, scheme});
  }
  using Stepper = decltype(make(std::declval<const S&>(), std::declval<const Force&>(), std::declval<const Scheme&>()));
  static constexpr bool traced = [] {
    if constexpr (watched) return Stepper::facts.traces;
    else return false;
  }();

 public:
  Body(const Force& force, const Scheme& scheme) : stepper_{make(case_.state, force, scheme)} {
    if constexpr (traced) {
      PlainState<S> y;
      copy_blocks<S>(y, case_.state);
      trace_.resize(y);
    }
  }
  [[nodiscard]] bool drifts() const override { return Blocks<S>::drifts; }
  [[nodiscard]] bool halves() const override { return is_halving<Stepper>; }
  [[nodiscard]] bool traces() const override { return traced; }
  [[nodiscard]] int order() const override { return stepper_.order(); }
  StepReport step(double t, double dt) override { return stepper_.step(case_.state, t, dt); }
  void reset() override { stepper_.reset(); }
  [[nodiscard]] Statistics statistics() const override { return stepper_.statistics(); }
  [[nodiscard]] Eigen::VectorXd numbers() const override { return states::numbers(case_.state); }
  StepReport attempt(double t, double dt, bool accept) override {
    if constexpr (traced) {
      const StepReport done =
          stepper_.attempt(case_.state, t, dt, Origin::unknown, trace_, [accept](const auto&...) { return accept; });
      if (done) trace_.advance();
      return done;
    } else {
      throw std::logic_error("not watched");
    }
  }
  void forget() override {
    if constexpr (traced) trace_.forget();
  }
  void edit() override {
    if constexpr (traced) for_each_block([](auto, auto& block) { block = block * -1.5; }, Blocks<S>::all(case_.state));
  }

 private:
  struct Nothing {};
  Case case_;
  Stepper stepper_;
  [[no_unique_address]] std::conditional_t<traced, Trace<PlainState<S>>, Nothing> trace_;
};

template <class Case, bool watched = false, class Force, class Scheme, class Wrap = AsItIs>
[[nodiscard]] std::unique_ptr<Subject> subject_of(const Force& force, const Scheme& scheme, Wrap = {}) {
  return std::make_unique<Body<Case, Force, Scheme, Wrap, watched>>(force, scheme);
}

/// @param subject, twin  made alike, with forces that obey `mood`
inline void check_contract(Subject& subject, Subject& twin, Trouble& mood, int order) {
  CAPTURE(subject.name);
  CHECK(subject.order() == order);
  REQUIRE(subject.step(0, 0.01));  // whatever may be carried, is
  const Eigen::VectorXd before = subject.numbers();
  const auto unharmed = [&] { return same_bits(subject.numbers(), before); };

  for (const Trouble trouble : {Trouble::nan, Trouble::inf}) {
    mood = trouble;
    subject.reset();
    const StepReport report = subject.step(0.01, 0.02);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK_THAT(report.message(), contains("component") && contains("t = 0.01") && contains("Try"));
    if (!subject.halves()) CHECK_THAT(report.message(), contains("dt = 0.02"));
    CHECK(report.failure().block == (subject.drifts() ? 1 : 0));
    CHECK(unharmed());
  }
  mood = Trouble::exception;
  subject.reset();
  CHECK_THROWS_WITH(subject.step(0.01, 0.02), "moody");
  CHECK(unharmed());
  mood = Trouble::none;

  for (const double dt : {0.0, std::nan(""), HUGE_VAL, -HUGE_VAL})
    CHECK(subject.step(0.01, dt).outcome() == Outcome::invalid_step);
  for (const double t : {std::nan(""), HUGE_VAL}) CHECK(subject.step(t, 0.1).outcome() == Outcome::invalid_step);
  CHECK(subject.step(1.0, 1e-17).outcome() == Outcome::step_too_small);
  CHECK(subject.step(1.0, -1e-17).outcome() == Outcome::step_too_small);
  CHECK(unharmed());

  const Statistics s = subject.statistics();
  CHECK(s.steps == 1);
  CHECK(s.failed_steps == 10);

  // After all that it steps as one that never failed, forward and backward, to the bit.
  REQUIRE(twin.step(0, 0.01));
  twin.reset();  // as the other was
  for (const double dt : {0.02, -0.03}) {
    REQUIRE(subject.step(0.01, dt));
    REQUIRE(twin.step(0.01, dt));
    CHECK(same_bits(subject.numbers(), twin.numbers()));
  }
}

/// `force_of` makes the force from a Moody one, `Wrap` a stepper around the PhiStepper. A subject that is `watched` in
/// another test of the same file is best watched here, too: it is then compiled once.
template <class Case, bool watched = false, class Wrap = AsItIs>
void check_contract(auto scheme, int order, auto force_of, const char* name = "") {
  Trouble mood = Trouble::none;
  const auto force = force_of(Moody{&mood});
  const auto subject = subject_of<Case, watched>(force, scheme, Wrap{});
  const auto twin = subject_of<Case, watched>(force, scheme, Wrap{});
  subject->name = name;
  check_contract(*subject, *twin, mood, order);
}

/// Of a type that other tests of the same file may share.
template <class Case>
using ForceOf = shared_force::OfState<typename Case::Block>;

template <class Case, bool watched = false, class Wrap = AsItIs>
void check_contract(auto scheme, int order, const char* name = "") {
  check_contract<Case, watched, Wrap>(
      scheme, order, [](Moody force) -> ForceOf<Case> { return force; }, name);
}

}  // namespace states
