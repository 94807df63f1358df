// Several steps in one call of the stepper: what a run of them comes to must be, bit for bit and count for count, what the
// same steps one by one come to, whatever happens in them. A run with an observer does its steps one by one.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "support/catch.hpp"

using namespace phistep;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

enum class Fault { none, nan, inf, exception, wrong_size };

/// What a force does at its calls: it counts them, and fails at one.
struct Plan {
  Fault fault = Fault::none;
  long at = -1;
  long calls = 0;
  /// The force, spoilt where it is its turn.
  VectorXd result(const Vector3d& force) {
    VectorXd f = force;
    if (calls++ != at) return f;
    if (fault == Fault::nan) f[1] = std::numeric_limits<double>::quiet_NaN();
    if (fault == Fault::inf) f[2] = std::numeric_limits<double>::infinity();
    if (fault == Fault::exception) throw std::runtime_error("the force gave up");
    if (fault == Fault::wrong_size) f.resize(2);
    return f;
  }
};
Vector3d pull(const Vector3d& r) { return -r - 0.3 * r.squaredNorm() * r; }

// Forces of each kind. The motion's:
auto of_place(Plan& plan) {
  return [&plan](const Vector3d& r) { return plan.result(pull(r)); };
}
auto of_place_and_velocity(Plan& plan) {
  return [&plan](const Vector3d& r, const Vector3d& v) { return plan.result(pull(r) - 0.1 * v); };
}
auto of_time(Plan& plan) {
  return [&plan](const Vector3d& r, const Vector3d& v, double t) {
    return plan.result(pull(r) - 0.1 * v + Vector3d{std::sin(t), 0, 0});
  };
}
/// A spring that hardens with each step.
struct Hardening {
  struct Memory {
    double stiffness = 1;
    void archive(auto& ar) { ar("stiffness", stiffness); }
  };
  Plan* plan;
  [[maybe_unused]] static constexpr const char* name = "hardening";
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto& y, const Memory& memory, auto& out) const {
    out.force += plan->result(memory.stiffness * pull(y.r));
  }
  void commit(double, const auto&, Memory& memory) const { memory.stiffness *= 1.01; }
};
auto hardening(Plan& plan) { return Hardening{&plan}; }
// A first-order state's:
auto rate(Plan& plan) {
  return [&plan](const Vector3d& y, double t) { return plan.result(0.1 * pull(y) + Vector3d{0, t, 0}); };
}

/// What a run leaves.
template <class S>
struct Left {
  S state;
  Statistics counts;
  RunReport report;
  double time = 0;
  long calls = 0;
  std::string thrown;
};
/// Runs, goes on if something was thrown, then runs once more from where it stands, without faults.
/// @tparam one_by_one  with an observer
template <bool one_by_one, class S>
Left<S> left_by(S y, auto make_force, auto scheme, TimeSpan<double> span, double dt, Plan plan) {
  PhiStepper stepper{y, make_force(plan), scheme, mass(1.7)};
  Left<S> left{y, {}, {}, 0, 0, {}};
  const auto run_all = [&](auto& run) {
    try {
      static_cast<void>(run.finish());
    } catch (const std::runtime_error& error) {
      left.thrown = error.what();
      left.time = run.time();
      left.state = y;
      left.report = run.report();
      static_cast<void>(run.finish());
    }
    if (left.thrown.empty()) {
      left.state = y;
      left.report = run.report();
      left.time = run.time();
    }
  };
  const auto look = [](double, const S&) {};
  if constexpr (one_by_one) {
    Run run{stepper, y, span, fixed(dt), look};
    run_all(run);
  } else {
    Run run{stepper, y, span, fixed(dt)};
    run_all(run);
  }
  left.counts = stepper.statistics();
  left.calls = plan.calls;
  return left;
}

template <class S>
bool same(const S& a, const S& b) {
  return equal_blocks<S>(a, b);
}
template <class S>
void check_same(const Left<S>& a, const Left<S>& b) {
  CHECK(same(a.state, b.state));
  CHECK(a.counts == b.counts);
  CHECK(a.calls == b.calls);
  CHECK(a.time == b.time);
  CHECK(a.thrown == b.thrown);
  CHECK(a.report.outcome == b.report.outcome);
  CHECK(a.report.statistics == b.report.statistics);
  CHECK(a.report.t == b.report.t);
  CHECK(a.report.smallest_dt == b.report.smallest_dt);
  CHECK(a.report.largest_dt == b.report.largest_dt);
  CHECK(a.report.failure.message() == b.report.failure.message());
}

const Motion start{Vector3d{1, -0.5, 0.25}, Vector3d{0.1, 0.7, -0.2}};
const Vector3d first_order_start{1, -0.5, 0.25};

/// Spans of 1, 2, 3 and more steps, with and without a rest, forward and backward.
template <class S>
void check_all(const S& y, auto make_force, auto scheme) {
  for (const double dt : {0.0625, 0.1})
    for (const double length : {dt, 2 * dt, 3 * dt, 12 * dt, 5.3 * dt})
      for (const double sign : {1.0, -1.0}) {
        CAPTURE(dt, length, sign);
        const TimeSpan<double> span{0.75, 0.75 + sign * length};
        const Left<S> several = left_by<false>(y, make_force, scheme, span, dt, {});
        check_same(several, left_by<true>(y, make_force, scheme, span, dt, {}));
        CHECK(several.report.outcome == Outcome::success);
        CHECK(several.counts.steps == std::llround(std::ceil(length / dt - 1e-9)));
      }
}
template <class S>
void check_faults(const S& y, auto make_force, auto scheme, bool can_be_of_wrong_size = true) {
  const double dt = 0.125;
  const TimeSpan<double> span{0.0, 8 * dt};
  const long calls = left_by<true>(y, make_force, scheme, span, dt, {}).calls;
  for (const Fault fault : {Fault::nan, Fault::inf, Fault::exception, Fault::wrong_size})
    for (long at = 0; at < calls; ++at) {
      if (fault == Fault::wrong_size && !can_be_of_wrong_size) continue;
      CAPTURE(static_cast<int>(fault), at);
      const Plan plan{fault, at, 0};
      const Left<S> several = left_by<false>(y, make_force, scheme, span, dt, plan);
      check_same(several, left_by<true>(y, make_force, scheme, span, dt, plan));
      CHECK((several.report.outcome != Outcome::success || !several.thrown.empty()));
    }
}

}  // namespace

TEST_CASE("several steps in a call leave the bits and the counts of single steps") {
  SECTION("forward Euler") {
    check_all(
        start, [](Plan& p) { return of_place(p); }, forward_euler);
    check_all(
        start, [](Plan& p) { return of_time(p); }, forward_euler);
    check_all(
        first_order_start, [](Plan& p) { return rate(p); }, forward_euler);
  }
  SECTION("symplectic Euler") {
    check_all(
        start, [](Plan& p) { return of_place(p); }, symplectic_euler);
  }
  SECTION("velocity Verlet") {
    check_all(
        start, [](Plan& p) { return of_place(p); }, velocity_verlet);
    check_all(
        start, [](Plan& p) { return hardening(p); }, velocity_verlet);
  }
  SECTION("stages") {
    check_all(
        start, [](Plan& p) { return of_time(p); }, tsit5);
    check_all(
        start, [](Plan& p) { return of_place(p); }, srkn6b);
    check_all(
        first_order_start, [](Plan& p) { return rate(p); }, tsit5);
  }
}

TEST_CASE("a fault at any call of a run of several steps leaves what it leaves of single steps") {
  SECTION("forward Euler") {
    check_faults(
        start, [](Plan& p) { return of_place_and_velocity(p); }, forward_euler);
    check_faults(
        first_order_start, [](Plan& p) { return rate(p); }, forward_euler);
  }
  SECTION("velocity Verlet") {
    check_faults(
        start, [](Plan& p) { return of_place(p); }, velocity_verlet);
    check_faults(
        start, [](Plan& p) { return hardening(p); }, velocity_verlet, false);  // it adds: Eigen checks
  }
  SECTION("stages") {
    check_faults(
        start, [](Plan& p) { return of_place(p); }, srkn6b);
    check_faults(
        first_order_start, [](Plan& p) { return rate(p); }, tsit5);
  }
}

TEST_CASE("a state that overflows in a run of several steps is that of the last good step") {
  const auto run = [&](auto&&... look) {
    Motion y{Vector3d{1, 2, 3}, Vector3d{0, 3e307, 0}};
    PhiStepper stepper{y, [](const Vector3d&) -> Vector3d { return {0, 0, 1}; }, forward_euler};
    const RunReport report = integrate(stepper, y, {0.0, 40.0}, fixed(1.0), look...);
    CHECK(report.outcome == Outcome::non_finite_state);
    CHECK(y.r[1] == 2 + 5 * 3e307);
    CHECK(y.v[2] == 5);
    CHECK(report.failure.block == 0);
    CHECK(report.failure.index == 1);
    return std::tuple{y, report.t, report.statistics, report.failure.message()};
  };
  const auto look = [](double, const auto&) {};
  const auto [several, t, counts, message] = run();
  const auto [single, t1, counts1, message1] = run(look);
  CHECK(same(several, single));
  CHECK(t == t1);
  CHECK(counts == counts1);
  CHECK(counts.steps == 5);
  CHECK(message == message1);
}

TEST_CASE("a force that looks at the caller's state sees where each of several steps starts") {
  Motion y = start;
  long calls = 0, differing = 0;
  const auto looking = [&](const Vector3d& r) -> Vector3d {
    ++calls;
    differing += r != y.r;
    return -r - 0.1 * y.v;
  };
  PhiStepper stepper{y, looking, forward_euler};
  REQUIRE(integrate(stepper, y, {0.0, 2.0}, fixed(0.125)));
  CHECK(calls == 16);
  CHECK(differing == 0);
}

TEST_CASE("an edit after several steps in a call is noticed") {
  const auto run = [](auto&&... look) {
    Motion y = start;
    Plan plan;
    PhiStepper stepper{y, of_place(plan), velocity_verlet};
    REQUIRE(integrate(stepper, y, {0.0, 2.0}, fixed(0.125), look...));
    y.r[1] = std::nextafter(y.r[1], 2.0);
    REQUIRE(integrate(stepper, y, {2.0, 4.0}, fixed(0.125), look...));
    REQUIRE(stepper.step(y, 4.0, 0.125));
    return std::pair{y, plan.calls};
  };
  const auto look = [](double, const auto&) {};
  const auto [several, calls] = run();
  const auto [single, calls1] = run(look);
  CHECK(same(several, single));
  CHECK(calls1 == 2 * 16 + 2 + 1);
  CHECK(calls == calls1 + 1);  // after a run without observers it is not known whether the state was edited
}

TEST_CASE("a run begun step by step goes on in several steps a call") {
  Motion y = start, single = start;
  Plan plan, plan1;
  PhiStepper stepper{y, of_place(plan), velocity_verlet}, stepper1{single, of_place(plan1), velocity_verlet};
  Run run{stepper, y, {0.0, 2.0}, fixed(0.125)};
  for (int n = 0; n < 5; ++n) REQUIRE(run.advance());
  y.v *= 0.5;
  CHECK(run.finish().outcome == Outcome::success);
  for (int n = 0; n < 16; ++n) {
    if (n == 5) single.v *= 0.5;
    REQUIRE(stepper1.step(single, 0.125 * n, 0.125));
  }
  CHECK(same(y, single));
  CHECK(stepper.statistics() == stepper1.statistics());
}
