// Controlled runs that can't go on, or are not meant to: each a clear outcome, none a hang, nothing lost.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "contract/states.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"
#if PHISTEP_STRESS
#include <phistep/krylov.hpp>
#include <phistep/sparse.hpp>

#include <Eigen/IterativeLinearSolvers>

#include "failure/group.hpp"
#include "problems/slider.hpp"
#endif

using namespace phistep;
using problems::distance;
using Vec = Eigen::Vector2d;
using Moving = Motion<Vec>;
using Flow = problems::ForcedFlow<>;
using Swing = problems::ForcedMotion<>;

namespace runs_cases {

inline const double NaN = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

using Psi = shared_force::OfStateAndTime<Vec>;
using Look = std::function<void(double, const Vec&)>;

inline const Psi decay = [](const Vec& y, double) -> Vec { return Vec(-y[0], -2 * y[1]); };
inline Vec decayed(double t) { return {std::exp(-t), std::exp(-2 * t)}; }

/// y' = y² blows up at t = 1 where y(0) = 1.
inline const Psi square = [](const Vec& y, double) -> Vec { return y.cwiseProduct(y); };

inline void check_at_pole(const RunReport& report, const Vec& y, double shown, const Vec& last) {
  CHECK_FALSE(report);
  CHECK(report.outcome != Outcome::too_many_steps);
  CHECK(report.outcome != Outcome::invalid_step);
  CHECK(report.t == shown);
  CHECK(y == last);
  CHECK(y.allFinite());
  CHECK(report.t == Approx(1).margin(0.01));
  CHECK_FALSE(report.message().empty());
}
inline void check_before_nan(const RunReport& report, const Vec& y) {
  CHECK(report.outcome == Outcome::non_finite_force);
  CHECK_THAT(report.message(), contains("force is not finite") && contains("component 0"));
  CHECK(report.t <= 0.51);  // midpoint asks a quarter of its last, doubled step before its end
  CHECK(report.t >= 0.49);
  CHECK(y.allFinite());
  CHECK(distance(y, Vec(Vec(1, 2) * std::exp(-report.t))) <= 1e-3);
}
void for_each_scheme(auto&& f) {
  f("backward_euler", backward_euler), f("phi(0.7)", phi(0.7)), f("trapezoidal", trapezoidal), f("midpoint", midpoint);
  f("tr_bdf2", tr_bdf2), f("forward_euler", forward_euler), f("rannacher", rannacher);
}

/// That nothing has happened to (1, 2) when a run from t0 was refused.
inline void check_refused(const RunReport& report, const Vec& y, double t0, int shown) {
  CHECK(shown == 0);
  CHECK(y == Vec(1, 2));
  CHECK(report.t == Approx(t0));
  CHECK(report.statistics == Statistics{});
  CHECK_FALSE(report.message().empty());
}
RunReport refusal(const auto& control, TimeSpan<double> span = {0, 1}) {
  Vec y(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  int shown = 0;
  const RunReport report = integrate(stepper, y, span, control, Look([&](double, const Vec&) { ++shown; }));
  check_refused(report, y, span.t0, shown);
  return report;
}

inline const auto meet_pole = [](const char* name, auto scheme) {
  CAPTURE(name);
  Vec y(1, 0.5);
  PhiStepper stepper{y, square, scheme};
  double shown = 0;
  Vec last = y;
  // An order-1 scheme takes 1/(√2 rtol) steps while y grows e-fold, and y grows by e^37 until Δt is rounding: 26,000
  // steps at rtol = 1e-3.
  const RunReport report = integrate(stepper, y, {0, 3}, tolerance{.rtol = 1e-3, .max_steps = 200'000},
                                     Look([&](double t, const Vec& now) { shown = t, last = now; }));
  check_at_pole(report, y, shown, last);
};

/// Returns what limited most of its steps.
inline const auto meet_nan = [](const char* name, auto scheme) {
  CAPTURE(name);
  const Psi force = [](const Vec& y, double t) -> Vec { return t > 0.5 ? Vec(NaN, 1) : Vec(-y); };
  Vec y(1, 2);
  PhiStepper stepper{y, force, scheme};
  const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 2e-4, .max_steps = 10'000});
  check_before_nan(report, y);
  return report.limits.most().by;
};

inline const auto pass_jump = [](const char* name, auto scheme) {
  CAPTURE(name);
  const Psi force = [](const Vec&, double t) -> Vec { return t < 1.0 / 3 ? Vec(1, -1) : Vec(-2, 5); };
  Vec y(0.5, 0.5);
  PhiStepper stepper{y, force, scheme};
  const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-4, .max_steps = 5000});
  REQUIRE(report);
  CHECK(distance(y, Vec(0.5 + 1.0 / 3 - 4.0 / 3, 0.5 - 1.0 / 3 + 10.0 / 3)) <= 1e-3);
};

/// A force that throws, at whatever call.
void check_throws(auto start, auto psi, auto scheme, auto&& exact, const auto& control) {
  int calls = 0, fatal = 0;
  const auto force = [&calls, &fatal, psi](const auto&... args) {
    if (++calls == fatal) throw std::runtime_error("no more");
    return psi(args...);
  };
  using S = decltype(start);
  int total = 0;
  for (int k = 0; k == 0 || k <= total; k += 1 + k / 40) {
    S y = start, last = start;
    calls = 0, fatal = k;
    PhiStepper stepper{
        y,
        typename std::conditional_t<Blocks<S>::drifts,
                                    std::type_identity<std::function<Vec(const Vec&, const Vec&, double)>>,
                                    std::type_identity<std::function<Vec(const Vec&, double)>>>::type(force),
        scheme};
    Run run{stepper, y, {0.0, 1.0}, control};
    int thrown = 0;
    double t = 0;
    for (bool more = true; more;) {
      try {
        more = run.advance();
      } catch (const std::runtime_error&) {
        ++thrown;
        CHECK(run.time() == t);
        CHECK(states::same_bits(states::numbers(y), states::numbers(last)));
        CHECK_FALSE(run.has_ended());
      }
      last = y, t = run.time();
    }
    CAPTURE(k, run.report().message());
    CHECK(run.report());
    CHECK(run.time() == 1);
    CHECK(distance(y, exact(1.0)) <= 1e-2);
    if (k == 0) total = calls;
    else CHECK(thrown == 1);
  }
}

inline const auto flow = [](const Vec& y, double t) -> Vec { return Flow{}(y, t) / Flow::capacity; };

}  // namespace runs_cases

#if PHISTEP_QUICK

using namespace runs_cases;

TEST_CASE("t1 = t0: shown, done, unless the observer has had enough") {
  Vec y(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  int shown = 0;
  const RunReport report = integrate(stepper, y, {2, 2}, tolerance{}, Look([&](double, const Vec&) { ++shown; }));
  CHECK(report);
  CHECK(report.t == 2);
  CHECK(shown == 1);
  CHECK(report.statistics == Statistics{});
}

TEST_CASE("options that can't work are refused before anything happens") {
  std::string option;
  const auto refused = [&option](const tolerance& control, TimeSpan<double> span = {0, 1}) {
    const RunReport report = refusal(control, span);
    option = report.refused.option != nullptr ? report.refused.option : "";
    CHECK(!option.empty());
    CHECK_THAT(report.message(), contains(option));
    return report.outcome;
  };
  using enum Outcome;
  for (const double rtol : {0.0, -1e-4, NaN, inf, 1.0, 1e-15, 1e-300})
    CHECK(refused(tolerance{.rtol = rtol}) == invalid_tolerance);
  CHECK(option == "rtol, which is below rounding");
  for (const double atol : {-1.0, NaN, inf}) CHECK(refused(tolerance{.atol = atol}) == invalid_tolerance);
  CHECK_THAT(option, contains("atol"));
  CHECK(refused(tolerance{.atol = {1.0, 1.0}}) == invalid_tolerance);
  CHECK(refused(tolerance{.atol = Eigen::VectorXd::Ones(3).eval()}) == invalid_tolerance);
  for (const double bad : {-1.0, NaN}) {
    CHECK(refused(tolerance{.first_step = bad}) == invalid_tolerance);
    CHECK(refused(tolerance{.min_step = bad}) == invalid_tolerance);
    CHECK(refused(tolerance{.max_step = bad}) == invalid_tolerance);
  }
  CHECK(option == "max_step");
  CHECK(refused(tolerance{.max_step = 0.0}) == invalid_tolerance);
  CHECK(refused(tolerance{.min_step = 0.1, .max_step = 0.05}) == invalid_tolerance);
  CHECK(option == "min_step, which exceeds max_step");
  CHECK(refused(tolerance{.max_steps = -1}) == invalid_tolerance);
  CHECK(option == "max_steps");
  for (const double bad : {inf, -inf}) CHECK(refused(tolerance{}, {0, bad}) == invalid_step);
  CHECK(option == "t1 - t0");
  Vec y(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  CHECK(integrate(stepper, y, {0, NaN}, tolerance{}).outcome == invalid_step);
  CHECK(integrate(stepper, y, {NaN, 0}, tolerance{}).outcome == invalid_step);
}

TEST_CASE("a refusal prints what was given, and the least that works") {
  const RunReport tight = refusal(tolerance{.rtol = 1e-15});
  CHECK_THAT(tight.message(), contains("rtol, which is below rounding (1e-15; it works from "));
  CHECK(refusal(tolerance{.rtol = 0.99 * tight.refused.least}).outcome == Outcome::invalid_tolerance);
  CHECK_THAT(refusal(tolerance{.max_step = -2}).message(), contains("max_step (-2)"));
  Vec y(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  CHECK(integrate(stepper, y, {0, 1e-3}, tolerance{.rtol = 1.01 * tight.refused.least}));
  CHECK_THAT(integrate(stepper, y, {0, 1}, fixed(-0.1)).message(), contains("dt (-0.1)"));
  CHECK_THROWS_WITH(mass(Vec(1, -2)), contains("number 1 is -2"));
  CHECK_THROWS_WITH(phi(1 / 2), contains("write 0.5"));  // 1/2 is the integer 0
  CHECK_THROWS_WITH(phi_stage(1 / 2), contains("write 0.5"));
}

TEST_CASE("a start that is no number, a force that is none there") {
  Vec y(1, NaN);
  PhiStepper stepper{y, decay, trapezoidal};
  CHECK(integrate(stepper, y, {0, 1}, tolerance{}).outcome == Outcome::non_finite_state);
  Vec z(1, 2);
  PhiStepper nowhere{z, Psi([](const Vec&, double) -> Vec { return Vec(NaN, 0); }), trapezoidal};
  const RunReport report = integrate(nowhere, z, {0, 1}, tolerance{});
  CHECK(report.outcome == Outcome::non_finite_force);
  CHECK_THAT(report.message(), contains("force is not finite"));
  CHECK(z == Vec(1, 2));
}

TEST_CASE("bounds on steps and tries hold") {
  const auto run = [](const tolerance& control, auto scheme) {
    Vec y = decayed(0);
    PhiStepper stepper{y, decay, scheme};
    std::vector<double> times;
    const RunReport report =
        integrate(stepper, y, {0, 5}, control, Look([&](double t, const Vec&) { times.push_back(t); }));
    for (std::size_t n = 0; n + 1 < times.size(); ++n) CHECK(times[n + 1] - times[n] <= control.max_step * (1 + 1e-14));
    return std::pair{report, times};
  };
  const auto [capped, at] = run({.rtol = 2e-2, .max_step = 0.125}, trapezoidal);
  CHECK(capped);
  CHECK(at.size() >= 41);
  CHECK(capped.largest_dt <= 0.125);
  CHECK(capped.limits.most().by == LimitedBy::max_step);
  const auto [split, ends] = run({.rtol = 1e-2, .first_step = 5 / 40.005, .max_step = 5 / 40.005},
                                 trapezoidal);  // no last step of 1.005 times that
  CHECK(split);

  const auto [given, times] = run({.rtol = 1e-2, .first_step = 1e-5}, trapezoidal);
  CHECK(given);
  CHECK(times[1] == 1e-5);
  const auto [huge, big] = run({.rtol = 1e-2, .first_step = 1e300}, trapezoidal);
  CHECK(huge);

  const auto [tired, few] = run({.rtol = 1e-6, .max_steps = 7}, trapezoidal);
  CHECK(tired.outcome == Outcome::too_many_steps);
  CHECK(few.size() <= 8);
  CHECK(few.size() >= 2);
  const auto [none, start] = run({.rtol = 1e-6, .max_steps = 0}, trapezoidal);
  CHECK(none.outcome == Outcome::too_many_steps);
  CHECK(start.size() == 1);

  // A smallest step that the tolerance can't live with ends the run; one that it can is kept.
  const auto [floored, f] = run({.rtol = 1e-6, .min_step = 0.5}, trapezoidal);
  CHECK(floored.outcome == Outcome::step_too_small);
  CHECK_THAT(floored.message(), contains("smallest step"));
  const auto [kept, k] = run({.rtol = 1e-2, .first_step = 1e-5, .min_step = 1e-3}, trapezoidal);
  CHECK(kept);
  for (std::size_t n = 0; n + 2 < k.size(); ++n) CHECK(k[n + 1] - k[n] >= 0.999e-3);
}

TEST_CASE("through a pole there is no way: the run says so, the last good state stays") {
  meet_pole("trapezoidal", trapezoidal);
}

TEST_CASE("a pole that lies at t = 0, where no step is too small for the clock") {
  Vec y(1, 0.5);
  PhiStepper stepper{y, square, trapezoidal};
  const RunReport report = integrate(stepper, y, {-1, 2}, tolerance{.rtol = 1e-4, .max_steps = 200'000});
  CAPTURE(report.message(), report.t);
  CHECK_FALSE(report);
  CHECK(report.outcome != Outcome::too_many_steps);
  CHECK(report.outcome != Outcome::invalid_step);
}

TEST_CASE("a force that is no number from a time on: named, and the run ends before it") {
  CHECK(meet_nan("trapezoidal", trapezoidal) == LimitedBy::not_finite);
}

TEST_CASE("a force that throws, at whatever call: the last good step stands, and the run can go on") {
  check_throws(Flow::exact(0), flow, trapezoidal, Flow::exact, tolerance{.rtol = 1e-3});
}

TEST_CASE("an observer that throws leaves a run that can go on") {
  Vec y = decayed(0);
  PhiStepper stepper{y, decay, trapezoidal};
  int calls = 0;
  const Look observer = [&](double, const Vec&) {
    if (++calls % 5 == 1) throw std::runtime_error("look away");
  };
  Run run{stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-4}, observer};
  int thrown = 0;
  for (bool more = true; more;) {
    try {
      more = run.advance();
    } catch (const std::runtime_error&) {
      ++thrown;
    }
    REQUIRE(thrown < 1000);
  }
  CHECK(run.report());
  CHECK(thrown > 3);
  CHECK(distance(y, decayed(1)) <= 1e-3);
}

TEST_CASE("a jump in the force is passed, in short steps") { pass_jump("trapezoidal", trapezoidal); }

TEST_CASE("a step that the clock can't show any shorter is not tried again") {
  // Two ticks of the clock, and far too long for the tolerance: the stop is within its rounding, whatever dt is wanted.
  int calls = 0;
  const auto counted = [&calls](const Eigen::VectorXd& y) -> Eigen::VectorXd {
    ++calls;
    return -y;
  };
  const auto ends = [&](auto scheme, double length) {
    CAPTURE(length);
    calls = 0;
    Eigen::VectorXd y = Eigen::VectorXd::Ones(2);
    phistep::PhiStepper stepper{y, counted, scheme};
    const auto report = phistep::integrate(stepper, y, {1e16, 1e16 + length}, phistep::tolerance{.rtol = 1e-6});
    CHECK(report.outcome == phistep::Outcome::step_too_small);
    CHECK(calls < 200);
    CHECK((report.statistics.steps > 0 || y == Eigen::VectorXd::Ones(2)));
  };
  for (const double length : {2.0, 4.0, -2.0}) ends(phistep::tsit5, length), ends(phistep::rodas5p, length);
  ends(phistep::trapezoidal, 4.0);
}

#elif PHISTEP_FULL

using namespace runs_cases;

TEST_CASE("t1 = t0: shown, done, unless the observer has had enough") {
  Vec y(1, 2);
  PhiStepper stepper{y, decay, trapezoidal};
  CHECK(integrate(stepper, y, {2, 2}, tolerance{}, [](double, const Vec&) { return false; }).outcome ==
        Outcome::stopped_by_observer);
}

TEST_CASE("options that can't work are refused before anything happens") {
  const auto refused = [](const auto& control) { return refusal(control).outcome; };
  using enum Outcome;
  for (const double bad : {-1.0, NaN}) {
    CHECK(refused(iteration_control{.first_step = bad}) == invalid_tolerance);
    CHECK(refused(iteration_control{.first_step = 0.1, .order = bad}) == invalid_tolerance);
    CHECK(refused(iteration_control{.first_step = 0.1, .min_step = bad}) == invalid_tolerance);
    CHECK(refused(iteration_control{.first_step = 0.1, .max_step = bad}) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{}, iteration_control{.first_step = bad})) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{}, iteration_control{.order = bad})) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{}, iteration_control{.min_step = bad})) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{}, iteration_control{.max_step = bad})) == invalid_tolerance);
    CHECK(refused(smaller_of(tolerance{.max_step = bad}, iteration_control{.max_step = 1})) == invalid_tolerance);
  }
  CHECK(refused(iteration_control{}) == invalid_tolerance);
  CHECK(refused(iteration_control{.first_step = 0.1, .desired = 0}) == invalid_tolerance);
  CHECK(refused(smaller_of(tolerance{}, iteration_control{.desired = 0})) == invalid_tolerance);
}

TEST_CASE("a start that is no number, a force that is none there") {
  Vec y(1, NaN);
  PhiStepper stepper{y, decay, trapezoidal};
  CHECK(integrate(stepper, y, {0, 1}, iteration_control{.first_step = 0.1}).outcome == Outcome::non_finite_state);
}

TEST_CASE("through a pole there is no way: the run says so, the last good state stays") { for_each_scheme(meet_pole); }

TEST_CASE("a force that is no number from a time on: named, and the run ends before it") { for_each_scheme(meet_nan); }

TEST_CASE("a force that throws, at whatever call: the last good step stands, and the run can go on") {
  const auto swing = [](const Vec& r, const Vec& v, double t) -> Vec { return Swing{}(r, v, t) / Swing::mass; };
  const tolerance control{.rtol = 1e-3};
  check_throws(Flow::exact(0), flow, trapezoidal, Flow::exact, control);
  check_throws(Flow::exact(0), flow, tr_bdf2, Flow::exact, control);
  check_throws(Flow::exact(0), flow, midpoint, Flow::exact, control);
  check_throws(Swing::exact(0), swing, velocity_verlet, Swing::exact, control);
  check_throws(Swing::exact(0), swing, backward_euler, Swing::exact, control);
  check_throws(Flow::exact(0), flow, trapezoidal, Flow::exact, fixed(0.02));
  check_throws(Flow::exact(0), flow, trapezoidal, Flow::exact, iteration_control{.first_step = 0.01, .max_step = 0.02});
}

TEST_CASE("a jump in the force is passed, in short steps") { for_each_scheme(pass_jump); }

#elif PHISTEP_STRESS
// Failures at every call, around the schemes: Jacobians, linear solvers, every way to solve, controlled runs, observers,
// events and their handlers, forces with a history.

using namespace faults;
using problems::Slider;

namespace {

const auto motion = [] { return states::SecondOrder<Eigen::VectorXd>{}.state; };
const auto flow = [] { return states::FirstOrder<Eigen::VectorXd>{}.state; };
auto with(auto f, auto... more) {
  return [=](auto& y) { return PhiStepper{y, f, more...}; };
}
const std::vector<Kind> numbers{Kind::nan, Kind::inf, Kind::exception};
const Promise to_rounding{.same_end = 1e-13, .renewed = 1e-12};

/// A chain of cubic springs to the left neighbour; asks the fault before it answers.
struct Chain {
  Eigen::VectorXd operator()(const Eigen::VectorXd& y) const {
    Eigen::VectorXd f(y.size());
    for (Index i = 0; i < y.size(); ++i) f[i] = -2 * y[i] - y[i] * y[i] * y[i] + (i > 0 ? y[i - 1] : 0);
    return struck<Eigen::VectorXd>(Site::force, f);
  }
};
struct DenseChain : Chain {
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& y) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(y.size(), y.size());
    for (Index i = 0; i < y.size(); ++i) J(i, i) = -2 - 3 * y[i] * y[i];
    for (Index i = 1; i < y.size(); ++i) J(i, i - 1) = 1;
    return struck<Eigen::MatrixXd>(Site::jacobian, J);
  }
};
struct SparseChain : Chain {
  Eigen::SparseMatrix<double> jacobian(const Eigen::VectorXd& y) const {
    Eigen::SparseMatrix<double> J(y.size(), y.size());
    const bool bad = fault.strikes(Site::jacobian);
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < static_cast<int>(y.size()); ++i) {
      entries.emplace_back(i, i, bad && i == 2 ? fault.bad() : -2 - 3 * y[i] * y[i]);
      if (i > 0) entries.emplace_back(i, i - 1, 1.0);
    }
    J.setFromTriplets(entries.begin(), entries.end());
    return J;
  }
};
/// LU that refuses, throws, or answers nonsense when the fault says so.
class Fragile : public Eigen::SparseLU<Eigen::SparseMatrix<double>> {
  using Base = Eigen::SparseLU<Eigen::SparseMatrix<double>>;

 public:
  void analyzePattern(const Eigen::SparseMatrix<double>& W) {
    refuses_ = fault.strikes(Site::solver) && fault.kind == Kind::refuses;
    Base::analyzePattern(W);
  }
  void factorize(const Eigen::SparseMatrix<double>& W) {
    refuses_ = fault.strikes(Site::solver) && fault.kind == Kind::refuses;
    Base::factorize(W);
  }
  [[nodiscard]] Eigen::ComputationInfo info() const { return refuses_ ? Eigen::NoConvergence : Base::info(); }
  [[nodiscard]] Eigen::VectorXd solve(const auto& b) const {
    Eigen::VectorXd x = Base::solve(b);
    if (fault.strikes(Site::solver)) {
      if (fault.kind == Kind::refuses) refuses_ = true;
      else x[0] = fault.bad();
    }
    return x;
  }

 private:
  mutable bool refuses_ = false;
};

struct Damped {
  Eigen::VectorXd operator()(const Eigen::VectorXd& r, const Eigen::VectorXd& v, double t) const {
    return struck<Eigen::VectorXd>(Site::force, states::DampedPull{}(r, v, t));
  }
};
struct Pull {
  Eigen::VectorXd operator()(const Eigen::VectorXd& r) const {
    return struck<Eigen::VectorXd>(Site::force, states::Pull{}(r));
  }
};
struct Driven {
  Eigen::VectorXd operator()(const Eigen::VectorXd& y, double t) const {
    return struck<Eigen::VectorXd>(Site::force, states::DrivenPull{}(y, t));
  }
};
struct Push : ForceTerm {  // beside other terms; spoils what they have added
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto&, auto& out) const {
    if (fault.strikes(Site::force)) out.force.data()[1] = fault.bad();
  }
};

}  // namespace

TEST_CASE("Jacobians and linear solvers that fail") {
  Group group{"Jacobian or solver"};
  const auto go = [&](const char* label, auto stepper, Site site, const std::vector<Kind>& kinds) {
    group.add(label, machine(flow, stepper, 0.6, fixed(0.1)), site, kinds, to_rounding);
  };
  go("dense Jacobian, trapezoidal", with(DenseChain{}, trapezoidal), Site::jacobian, numbers);
  go("dense Jacobian, rodas4", with(DenseChain{}, rodas4), Site::jacobian, numbers);
  go("dense Jacobian, radau", with(DenseChain{}, radau), Site::jacobian, numbers);
  go("dense Jacobian, rodas4p2", with(DenseChain{}, rodas4p2), Site::jacobian, numbers);
  go("sparse Jacobian, tr_bdf2", with(SparseChain{}, tr_bdf2), Site::jacobian, numbers);
  const std::vector<Kind> solver_kinds{Kind::nan, Kind::refuses, Kind::exception};
  go("own solver, backward_euler", with(SparseChain{}, backward_euler, newton<Fragile>()), Site::solver, solver_kinds);
  go("own solver, rodas4", with(SparseChain{}, rodas4, newton<Fragile>()), Site::solver, solver_kinds);
  group.tell();
}

TEST_CASE("every way to solve") {
  Group group{"ways to solve"};
  const auto go = [&](const char* label, auto start, auto stepper) {
    group.add(label, machine(start, stepper, 0.6, fixed(0.1)), Site::force, numbers, to_rounding);
  };
  go("banded", flow, with(banded(Chain{}, 1, 0), trapezoidal));
  go("fixed_point", flow, with(Chain{}, trapezoidal, fixed_point()));
  go("linearly_implicit", flow, with(Chain{}, trapezoidal, linearly_implicit()));
  Promise by_solver = to_rounding;
  by_solver.in_solver = true;  // products with the matrix are force calls
  group.add("Krylov",
            machine(flow, with(Chain{}, backward_euler, newton<MatrixFree<>>({.linear_rtol = 1e-12})), 0.6, fixed(0.1)),
            Site::force, numbers, by_solver);
  go("springs, conjugate gradients", motion, with(spring_network<3>({{0, 1, 3.0, 1.0}}) + Push{}, backward_euler));
  go("splitting", motion, with(term(Damped{}) + at(forward_euler, Push{}), trapezoidal));
  go("history, Verlet", motion, with(Slider{} + Push{}, velocity_verlet));
  go("history, trapezoidal", motion, with(Slider{} + Push{}, trapezoidal));
  // Around a fault that passes, half steps lead, and are more accurate.
  const Promise by_halves{.same_end = 1e-13, .renewed = 1e-2};
  group.add("Halving",
            machine(
                flow,
                [](auto& y) {
                  return Halving{PhiStepper{y, Chain{}, backward_euler}, 2};
                },
                0.6, fixed(0.1)),
            Site::force, numbers, by_halves);
  group.add("history, Halving",
            machine(
                motion,
                [](auto& y) {
                  return Halving{PhiStepper{y, Slider{} + Push{}, backward_euler}, 2};
                },
                0.6, fixed(0.05)),
            Site::force, numbers, by_halves);
  group.tell();
}

TEST_CASE("controlled runs") {
  Group group{"controlled runs"};
  // What a failure does to Δt changes the end within the tolerance.
  const Promise within{.same_end = 2e-3, .renewed = 2e-3};
  const tolerance control{.rtol = 1e-3, .atol = 1e-4};
  const auto go = [&](const char* label, auto start, auto stepper, const auto& by) {
    group.add(label, machine(start, stepper, 0.6, by), Site::force, numbers, within);
  };
  go("trapezoidal", flow, with(Driven{}, trapezoidal), control);
  go("tr_bdf2", motion, with(Damped{}, tr_bdf2), control);
  go("phi_stage by doubling", flow, with(Driven{}, phi_stage(0.7)), tolerance{.rtol = 1e-2, .atol = 1e-3});
  go("velocity_verlet", motion, with(Damped{}, velocity_verlet), control);
  go("rodas4", flow, with(Driven{}, rodas4), control);
  go("radau", flow, with(Driven{}, radau), control);
  go("tsit5", flow, with(Driven{}, tsit5), control);
  go("dop853", motion, with(Damped{}, dop853), control);
  go("rkn86", motion, with(Pull{}, rkn86), control);
  go("iteration_control", flow, with(Chain{}, trapezoidal, fixed_point()),
     iteration_control{.first_step = 0.05, .order = 1, .max_step = 0.1});
  // Of friction that sticks and slips at rtol = 1e-2, ends can't be compared: another Δt, another slip.
  const double any = std::numeric_limits<double>::infinity();
  group.add("history, Halving, tolerance",
            machine(
                motion,
                [](auto& y) {
                  return Halving{PhiStepper{y, Slider{} + Push{}, backward_euler}, 2};
                },
                0.6, tolerance{.rtol = 1e-2, .atol = 1e-3}),
            Site::force, numbers, {.same_end = any, .renewed = any});
  group.tell();
}

TEST_CASE("observers, events and handlers") {
  Group group{"observers and events"};
  const auto watched = [] {
    return std::tuple{event(
                          [](const auto& y) {
                            const double g = y.r[0] - 0.35;
                            return fault.strikes(Site::event) ? fault.bad() : g;
                          },
                          {},
                          [](double, auto& y) {
                            y.v[0] *= -0.9;
                            static_cast<void>(fault.strikes(Site::handler));
                          }),
                      Recorder<Motion<Eigen::VectorXd>>{}, at_times({0.15, 0.33}, [](double, const auto&) {}),
                      sampled(0.07, [](double, const auto&) {}),
                      [](double, const auto&) { static_cast<void>(fault.strikes(Site::observer)); }};
  };
  const auto go = [&](const char* label, auto stepper, const auto& control, double tolerated) {
    const Make make = machine(motion, stepper, 0.9, control, watched);
    const Promise behind{.same_end = tolerated, .renewed = 1e-2, .moves_on = true};  // … with a grid of its own
    // Interpolation asks the force for slopes, for the observers' sake.
    group.add((label + std::string(", force")).c_str(), make, Site::force, numbers, behind);
    group.add((label + std::string(", event")).c_str(), make, Site::event, numbers, behind);
    group.add((label + std::string(", handler")).c_str(), make, Site::handler, {Kind::exception}, behind);
    group.add((label + std::string(", observer")).c_str(), make, Site::observer, {Kind::exception}, behind);
  };
  go("fixed, Verlet", with(Pull{}, velocity_verlet), fixed(0.1), 1e-12);
  go("fixed, trapezoidal", with(Damped{}, trapezoidal), fixed(0.1), 1e-12);
  go("tolerance, tr_bdf2", with(Damped{}, tr_bdf2), tolerance{.rtol = 1e-4, .atol = 1e-5}, 1e-3);
  group.tell();
}

#endif
