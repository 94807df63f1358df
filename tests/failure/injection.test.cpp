// NaN, infinity or an exception at every force call of a step: the state keeps every bit, and nothing is silent.
#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace injection_cases {

enum class Trouble { nan, inf, exception };

/// Goes wrong at its `at`-th call, and with `lasting` ever after.
struct Fault {
  int calls = 0, at = -1;
  bool lasting = true;
  Trouble trouble = Trouble::nan;
  Eigen::Index where = 4;

  void strike(auto& f) {
    const int call = calls++;
    if (at < 0 || (lasting ? call < at : call != at)) return;
    if (trouble == Trouble::exception) throw std::runtime_error("struck");
    component(f, where) = trouble == Trouble::nan ? std::nan("") : HUGE_VAL;
  }
};
struct Struck {  // f(r) or f(y)
  Fault* fault;
  auto operator()(const auto& r) const {
    auto f = Pull{}(r);
    fault->strike(f);
    return f;
  }
};
struct StruckDamped {  // f(r, v, t)
  Fault* fault;
  auto operator()(const auto& r, const auto& v, double t) const {
    auto f = DampedPull{}(r, v, t);
    fault->strike(f);
    return f;
  }
};
struct StruckAdding : ForceTerm {
  Fault* fault;
  explicit StruckAdding(Fault* f) : fault{f} {}
  void add(double t, const auto& y, auto& out) const {
    out.force += DampedPull{}(y.r, y.v, t);
    fault->strike(out.force);
  }
};

/// A stepper with its state and its fault, whatever their types.
class Subject {
 public:
  Fault fault;
  virtual ~Subject() = default;
  [[nodiscard]] virtual StepReport step(double t, double dt) = 0;
  virtual void edit() = 0;
  [[nodiscard]] virtual Eigen::VectorXd numbers() const = 0;
  /// Where a new stepper with the same history gets to.
  [[nodiscard]] virtual Eigen::VectorXd fresh_step(double t, double dt) const = 0;
  /// The scheme has a memory of its own: a new stepper lacks it.
  [[nodiscard]] virtual bool looks_back() const = 0;
};
template <class Case, class Force, class Scheme>
class SubjectOf final : public Subject {
 public:
  explicit SubjectOf(const Scheme& scheme) : scheme_{scheme}, stepper_{case_.state, Force{&fault}, scheme} {}
  StepReport step(double t, double dt) override { return stepper_.step(case_.state, t, dt); }
  void edit() override { component(std::get<0>(Blocks<typename Case::State>::all(case_.state)), 1) += 0.01; }
  Eigen::VectorXd numbers() const override { return states::numbers(case_.state); }
  Eigen::VectorXd fresh_step(double t, double dt) const override {
    Fault none;
    PlainState<typename Case::State> y;
    copy_blocks<typename Case::State>(y, case_.state);
    PhiStepper fresh{y, Force{&none}, scheme_};
    static_assert(!remembers<Force>);
    REQUIRE(fresh.step(y, t, dt));
    return states::numbers(y);
  }
  bool looks_back() const override { return SchemeOn<Scheme, typename Case::State>::looks_back; }

 private:
  Case case_;
  Scheme scheme_;
  PhiStepper<typename Case::State, Force, Scheme> stepper_;
};

/// The second step of a run, so that whatever may be carried is; edited, so that the state is not what the stepper left.
inline void inject(const std::function<std::unique_ptr<Subject>()>& make, bool edited) {
  int calls_of_a_step = 0;
  Eigen::VectorXd good;
  for (int at = -1; at < calls_of_a_step; ++at)
    for (const bool lasting : {true, false})
      for (const Trouble trouble : {Trouble::nan, Trouble::inf, Trouble::exception}) {
        const auto subject = make();
        REQUIRE(subject->step(0.1, 0.1));
        if (edited) subject->edit();
        subject->fault = {.at = at, .lasting = lasting, .trouble = trouble};
        const Eigen::VectorXd before = subject->numbers();
        CAPTURE(at, lasting, static_cast<int>(trouble));
        if (at < 0) {
          REQUIRE(subject->step(0.2, 0.1));
          calls_of_a_step = subject->fault.calls;
          good = subject->numbers();
          continue;
        }
        try {
          const StepReport report = subject->step(0.2, 0.1);
          CHECK(trouble != Trouble::exception);
          if (report) {  // Newton may step around a fault that passes, but never to another answer
            CHECK_FALSE(lasting);
            CHECK(distance(subject->numbers(), good) <= 1e-13);
            continue;
          }
          CHECK((report.outcome() == Outcome::non_finite_force || report.outcome() == Outcome::non_finite_jacobian));
          CHECK_THAT(report.message(), contains("t = 0.2") && contains("dt = 0.1") && contains("Try: "));
          if (lasting && report.outcome() == Outcome::non_finite_force)
            CHECK_THAT(report.message(), contains("component"));
        } catch (const std::runtime_error& error) {
          CHECK(trouble == Trouble::exception);
          CHECK(error.what() == std::string("struck"));
        }
        CHECK(same_bits(subject->numbers(), before));
        // And the stepper is none the worse for it: it is a new one.
        subject->fault.at = -1;
        const Eigen::VectorXd fresh = subject->fresh_step(0.2, 0.1);
        REQUIRE(subject->step(0.2, 0.1));
        if (!subject->looks_back() || edited) CHECK(same_bits(subject->numbers(), fresh));
        CHECK(distance(subject->numbers(), good) <= 1e-13);
      }
  CHECK(calls_of_a_step > 0);
}
template <class Case, class Force, class Scheme>
void inject(const Scheme& scheme) {
  const auto make = [&scheme] { return std::make_unique<SubjectOf<Case, Force, Scheme>>(scheme); };
  inject(make, false);
  inject(make, true);
}

void check_message(auto scheme) {
  Fault fault{.at = 0, .where = 5};
  SecondOrder<Columns> c;
  PhiStepper stepper{c.state, LinearDrag{0.1} + StruckAdding{&fault}, scheme};
  const StepReport report = stepper.step(c.state, 0.5, 0.25);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK_THAT(report.message(), contains("component 5") && contains("particle 1, row 2") && contains("term 1") &&
                                   contains("t = 0.5") && contains("dt = 0.25"));
}
void check_bad_state(const auto& force, auto scheme) {
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    SecondOrder<Dynamic> c;
    PhiStepper stepper{c.state, force, scheme};
    REQUIRE(stepper.step(c.state, 0, 0.1));
    c.state.v[4] = bad;
    const Eigen::VectorXd before = numbers(c.state);
    const StepReport report = stepper.step(c.state, 0.1, 0.1);
    CHECK(report.outcome() == Outcome::non_finite_state);
    CHECK(report.failure().block == 1);
    CHECK(report.failure().index == 4);
    CHECK(same_bits(numbers(c.state), before));
  }
}

}  // namespace injection_cases

using namespace injection_cases;

#if PHISTEP_QUICK

TEST_CASE("every call of every scheme, dynamic motion, f(r)") {
  inject<SecondOrder<Dynamic>, Struck>(velocity_verlet);
  inject<SecondOrder<Dynamic>, Struck>(trapezoidal);
}

TEST_CASE("every call of every scheme, fixed motion, f(r, v, t)") {
  inject<SecondOrder<Fixed>, StruckDamped>(symplectic_euler);
}

TEST_CASE("every call of every scheme, first order in a strided view") {
  inject<FirstOrder<Strided>, Struck>(forward_euler);
}

TEST_CASE("the message names the component, the particle and the term") { check_message(forward_euler); }

TEST_CASE("a state that is not finite is blamed before the force that it spoils") {
  Fault none;
  check_bad_state(Struck{&none}, velocity_verlet), check_bad_state(Struck{&none}, trapezoidal);
}

#elif PHISTEP_FULL

TEST_CASE("every call of every scheme, dynamic motion, f(r)") {
  for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    inject<SecondOrder<Dynamic>, Struck>(scheme);
  });
}

TEST_CASE("every call of every scheme, fixed motion, f(r, v, t)") {
  for_each_motion_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    inject<SecondOrder<Fixed>, StruckDamped>(scheme);
  });
}

TEST_CASE("every call of every scheme, first order in a strided view") {
  for_each_first_order_scheme([](const char* name, auto scheme) {
    CAPTURE(name);
    inject<FirstOrder<Strided>, Struck>(scheme);
  });
}

TEST_CASE("an accumulating force, on particles as columns") {
  inject<SecondOrder<Columns>, StruckAdding>(forward_euler);
  inject<SecondOrder<Columns>, StruckAdding>(velocity_verlet);
  inject<SecondOrder<Columns>, StruckAdding>(phi(0.7));
}

TEST_CASE("the message names the component, the particle and the term") {
  check_message(forward_euler), check_message(velocity_verlet);
  check_message(trapezoidal), check_message(backward_euler);
}

TEST_CASE("a mass matrix does not smear the blame over all components") {
  Fault fault{.at = 0, .where = 3};
  Eigen::MatrixXd M = Eigen::MatrixXd::Constant(6, 6, 0.1);
  M.diagonal().setConstant(2);
  const auto check = [&](auto scheme) {
    fault.calls = 0;
    SecondOrder<Dynamic> c;
    PhiStepper stepper{c.state, Struck{&fault}, scheme, mass(M)};
    const StepReport report = stepper.step(c.state, 0, 0.1);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(report.failure().index == 3);
    CHECK(same_bits(numbers(c.state), numbers(SecondOrder<Dynamic>{}.state)));
  };
  check(forward_euler), check(trapezoidal);
}

TEST_CASE("a force that returns a reference is blamed by name too") {
  Dynamic kept;
  Fault fault{.at = 0, .where = 2};
  const auto force = [&](const Dynamic& r) -> const Dynamic& {
    kept = Pull{}(r);
    fault.strike(kept);
    return kept;
  };
  SecondOrder<Dynamic> c;
  const auto check = [&](auto scheme, int at) {
    fault.calls = 0, fault.at = at;
    PhiStepper stepper{c.state, force, scheme};
    const StepReport report = stepper.step(c.state, 0, 0.1);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(report.failure().index == 2);
    CHECK(same_bits(numbers(c.state), numbers(SecondOrder<Dynamic>{}.state)));
  };
  check(forward_euler, 0), check(velocity_verlet, 0), check(velocity_verlet, 1), check(trapezoidal, 0);
}

TEST_CASE("a state that is not finite is blamed before the force that it spoils") {
  check_bad_state(DampedPull{}, forward_euler), check_bad_state(DampedPull{}, velocity_verlet);
  check_bad_state(DampedPull{}, trapezoidal), check_bad_state(DampedPull{}, midpoint);
}

#endif
