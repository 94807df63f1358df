// integrate without a stepper: what it takes, what it says, and that it loses nothing. The stepper: step/automatic_stepper.
#include "run/choice/automatic_cases.hpp"

#include <chrono>
#include <sstream>
#include <thread>

using namespace automatic_cases;

namespace {

/// Each type of force is five steppers to compile: one serves all. In the plane: z = 0 throughout.
using Space = Eigen::Vector3d;
using Force = shared_force::OfStateAndTime<Space>;
const Force steady = [](const Space& y, double) -> Space { return {-y[0], -2 * y[1], 0}; };
const Force reaction = [](const Space& y, double) -> Space { return Robertson{}(y); };

}  // namespace

TEST_CASE("what is not stiff: the bits of the pair by hand, no Jacobian, three calls for a look") {
  Space y{1, 1, 0}, same = y;
  const tolerance wanted{.rtol = 1e-6};
  const AutomaticReport report = integrate(y, steady, {0.0, 1.0}, wanted);
  const RunReport hand = by_hand(same, steady, dop853, {0.0, 1.0}, wanted);
  REQUIRE(report);
  CHECK(y == same);
  CHECK(report.statistics.jacobians == 0);
  CHECK(report.statistics.factorizations == 0);
  CHECK(report.statistics.steps == hand.statistics.steps);
  CHECK(report.statistics.force_calls == hand.statistics.force_calls + 3);
  REQUIRE(report.schemes.count() == 1);
  CHECK(report.schemes.list()[0].scheme == SuitableScheme::dormand_prince_8);
}

TEST_CASE("what is stiff from the start: the bits of the implicit scheme by hand") {
  Space y{1, 1, 0}, same = y;
  const tolerance wanted{.rtol = 1e-6};
  const Force forced = [](const Space& x, double t) -> Space {
    return {-1e6 * (x[0] - std::cos(t)) - std::sin(t), -x[1], 0};
  };
  const AutomaticReport report = integrate(y, forced, {0.0, 1.0}, wanted);
  const RunReport hand = by_hand(same, forced, radau, {0.0, 1.0}, wanted);
  REQUIRE(report);
  CHECK(y == same);
  CHECK(report.statistics.steps == hand.statistics.steps);
  CHECK(report.statistics.jacobians == hand.statistics.jacobians);
  CHECK(report.statistics.force_calls == hand.statistics.force_calls + 2 + 5);  // the first step anew, the look
  REQUIRE(report.schemes.count() == 2);
  CHECK(report.schemes.list()[1].cause == SchemeCause::stiff_start);
  CHECK(report.schemes.list()[1].step == 0);
}

TEST_CASE("stiffness that comes later is noticed within few steps, once") {
  for (const double rtol : {1e-3, 1e-6, 1e-9}) {
    auto y = Robertson::start();
    const auto report = integrate(y, reaction, {0.0, Robertson::end}, {.rtol = rtol, .atol = 1e-8 * rtol});
    REQUIRE(report);
    CHECK((y - Robertson::exact()).cwiseQuotient(Robertson::exact()).cwiseAbs().maxCoeff() < 10 * rtol);
    REQUIRE(report.schemes.count() == 2);
    const SchemeUse& use = report.schemes.list()[1];
    CHECK(use.cause == SchemeCause::stiff);
    // 21, 35 and 51: atol is so small that y2, which starts at 0, is followed to its own digits (runge_kutta_estimate.hpp).
    CHECK(use.step <= 60);
    CHECK(use.rate == Approx(2190).epsilon(0.02));
    CHECK(report.statistics.steps < 100);
  }
}

TEST_CASE("a relaxation oscillation: both ways, to the tolerance") {
  for (const double rtol : {1e-3, 1e-6}) {
    const tolerance wanted{.rtol = rtol, .atol = rtol};
    const Force oscillator = [](const Space& x, double) -> Space {
      const Vec rate = Oscillator{100}(x.head<2>());
      return {rate[0], rate[1], 0};
    };
    Space y{2, 0, 0}, exact = y;
    const AutomaticReport report = integrate(y, oscillator, {0.0, 500.0}, wanted);
    REQUIRE(report);
    REQUIRE(by_hand(exact, oscillator, radau, {0.0, 500.0}, {.rtol = 1e-11, .atol = 1e-11}));
    CHECK((y - exact).norm() < 30 * rtol);
    bool to_implicit = false, to_explicit = false;
    for (const SchemeUse& use : report.schemes.list()) {
      to_implicit = to_implicit || use.cause == SchemeCause::stiff || use.cause == SchemeCause::stiff_start;
      to_explicit = to_explicit || use.cause == SchemeCause::eased;
    }
    CHECK(to_implicit);
    CHECK((to_explicit || rtol > 1e-6));  // at few digits rodas4p2's steps are as cheap in the jumps
    CHECK(report.schemes.count() < 20);
    CHECK(report.statistics.steps < 1500);
  }
}

TEST_CASE("the report says in words what it took, when and why") {
  auto y = Robertson::start();
  const auto report = integrate(y, reaction, {0.0, 1.0}, {.rtol = 1e-6, .atol = 1e-14});
  std::ostringstream text;
  text << report;
  CHECK_THAT(text.str(), contains("success") && contains("schemes\n  dop853 from t = 0\n  radau from t = 0.0") &&
                             contains("stiff, the fastest mode held dt at 0.00"));
}

TEST_CASE("no clock: a force that takes its time gets the same bits") {
  const auto run = [](const Force& force) {
    auto y = Robertson::start();
    const auto report = integrate(y, force, {0.0, 1.0}, {.rtol = 1e-4, .atol = 1e-12});
    return std::pair{y, report.statistics};
  };
  const auto quick = run(reaction);
  const auto slowly = run([](const Space& y, double) -> Space {
    std::this_thread::sleep_for(std::chrono::microseconds(10));
    return Robertson{}(y);
  });
  CHECK(quick.first == slowly.first);
  CHECK(quick.second == slowly.second);
}

TEST_CASE("events and samples across a change of scheme are those of one scheme") {
  std::vector<double> times;
  for (int k = 1; k <= 60; ++k) times.push_back(1e-5 * std::pow(10.0, k / 12.0));
  std::vector<Eigen::Vector3d> seen, right;
  double crossed = 0, right_crossing = 0;
  const auto g = [](double, const Eigen::Vector3d& y) { return y[2] - 1e-4; };
  const auto run = [&](double rtol, bool automatic, auto& films, double& crossing) {
    auto y = Robertson::start();
    const tolerance wanted{.rtol = rtol, .atol = 1e-8 * rtol};
    auto film = sampled(times, [&](double, const Eigen::Vector3d& now) { films.push_back(now); });
    auto cross = event(g, [&](double t, Eigen::Vector3d&) { crossing = t; });
    if (automatic) return static_cast<bool>(integrate(y, reaction, {0.0, 1.0}, wanted, film, cross));
    PhiStepper stepper{y, reaction, radau};
    return static_cast<bool>(integrate(stepper, y, {0.0, 1.0}, wanted, film, cross));
  };
  REQUIRE(run(1e-6, true, seen, crossed));
  REQUIRE(run(1e-11, false, right, right_crossing));
  REQUIRE(seen.size() == times.size());
  REQUIRE(right.size() == times.size());
  CHECK(crossed == Approx(right_crossing).epsilon(1e-5));
  for (std::size_t k = 0; k < times.size(); ++k)
    CHECK(((seen[k] - right[k]).array() / (right[k].array().abs() + 1e-8)).abs().maxCoeff() < 1e-5);
}
