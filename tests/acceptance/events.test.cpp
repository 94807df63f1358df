// Events in whole runs: bouncing balls, collisions with a dashpot. Every scheme, every kind of control:
// events.full.cpp.
#include "acceptance/events_cases.hpp"

#include <phistep/run/observers/at_times.hpp>

#include <algorithm>
#include <stdexcept>
#include <tuple>

TEST_CASE("a bouncing ball meets all its bounces to 1e-12, whatever the step, and the run ends at Zeno's time") {
  for (const double dt : {0.001, 0.0123, 0.5, 50.0}) {
    CAPTURE(dt);
    check_falling_ball(velocity_verlet, fixed(dt));
  }
  check_falling_ball(velocity_verlet, tolerance{.rtol = 1e-6, .atol = 1e-9});
}

TEST_CASE("a collision with a dashpot, ended by an event: order 2 in Δt") { check_orders(by(trapezoidal)); }

TEST_CASE("a collision with a dashpot: restitution to 1e-8, and the digits of the table") {
  CHECK(Dashpot::separation_time() == Approx(7.031850e-3).epsilon(1e-6));
  CHECK(Dashpot::separation_speed() == Approx(0.868804629).epsilon(1e-9));
  CHECK(Dashpot::zero_force_time() == Approx(6.831583e-3).epsilon(1e-6));
  CHECK(Dashpot::zero_force_speed() == Approx(0.872291467).epsilon(1e-9));
  check_fine(by(trapezoidal));
}

TEST_CASE("a first-order run stops where its solution reaches a value") {
  // Forward and backward.
  // Error of the rule: t Δt²/12.
  CHECK(std::abs(reached(fixed(1e-3), 5, 0.5) - std::log(2)) <= 1e-7);
  CHECK(std::abs(reached(fixed(1e-3), -5, 2.0) + std::log(2)) <= 1e-7);
}

TEST_CASE("after an event a run keeps to its grid, and meets the given times") {
  Ball y{One{1}, One{0}};
  PhiStepper stepper{y, weight, velocity_verlet};
  auto bounce = bouncing(0.9);
  std::vector<double> ends, given;
  const auto report = integrate(
      stepper, y, {0, 2}, fixed(0.1), bounce, [&](double t, const Ball&) { ends.push_back(t); },
      at_times({0.5, 1.55}, [&](double t, const Ball&) { given.push_back(t); }));
  CHECK(report);
  CHECK(given == std::vector<double>{0.5, 1.55});
  REQUIRE(bounce.times().size() == 3);
  std::vector<double> expected;
  for (int n = 0; n <= 20; ++n) expected.push_back(n == 20 ? 2 : n * 0.1);
  expected.insert(expected.end(), {1.55, bounce.times()[0], bounce.times()[1], bounce.times()[2]});
  std::sort(expected.begin(), expected.end());
  CHECK(ends == expected);
}

TEST_CASE("of runs in a row one finds a root at their joint") {
  for (int k = 1; k <= 12; ++k) {
    Eigen::Vector2d y{0, 0};
    PhiStepper stepper{y, [](const Eigen::Vector2d&) -> Eigen::Vector2d { return {1, -1}; }, trapezoidal};
    auto passes = event([k](const Eigen::Vector2d& u) { return u[0] - 0.1 * k; });
    std::size_t times = 0;
    for (int j = 0; j < 14; ++j) {
      REQUIRE(integrate(stepper, y, {0.1 * j, 0.1 * (j + 1)}, fixed(0.01), passes));
      times += passes.times().size();
    }
    CHECK(times == 1);
  }
}

TEST_CASE("an event that throws leaves a state of the run") {
  One y{1};
  PhiStepper stepper{y, decay, trapezoidal};
  auto bad = event(OfOne{[](const One& x) -> double { return x(0) < 0.5 ? throw std::runtime_error("no") : 1.0; }});
  CHECK_THROWS_AS(integrate(stepper, y, {0, 5}, fixed(0.1), bad), std::runtime_error);
  CHECK(std::isfinite(y(0)));
}

TEST_CASE("a run edited between its steps: an edit through zero is no event") {
  Ball y{One{1}, One{0}};
  PhiStepper stepper{y, weight, velocity_verlet};
  auto ground = event(height);
  Run run{stepper, y, {0, 0.4}, fixed(0.05), ground};
  for (int n = 0; n < 4; ++n) REQUIRE(run.advance());
  y.r(0) -= 5;
  while (run.advance()) {
  }
  CHECK(run.report());
  CHECK(ground.times().empty());
}

TEST_CASE("a step with an event that doesn't happen costs no force call more, where the event looks at ends alone") {
  const auto calls = [](bool watched) {
    Ball y{One{1}, One{0}};
    PhiStepper stepper{y, decay, velocity_verlet};
    auto never = event(OfBall{[](const Ball& ball) { return ball.r(0) + 10; }}, {.inside = false});
    const auto report =
        watched ? integrate(stepper, y, {0, 10}, fixed(0.01), never) : integrate(stepper, y, {0, 10}, fixed(0.01));
    CHECK(report);
    return report.statistics.force_calls;
  };
  // Two for the slopes at the start, where one look tells that the run doesn't stand on the root.
  CHECK(calls(true) == calls(false) + 2);
}

TEST_CASE("how soon events follow each other is part of a checkpoint") {
  const auto play = [](std::size_t cut) {
    Ball y{One{1}, One{0}};
    PhiStepper stepper{y, weight, velocity_verlet};
    auto bounce = bouncing(0.3);
    Run first{stepper, y, {0, 4}, fixed(0.1), bounce};
    while (bounce.times().size() < cut && first.advance()) {
    }
    Writer out;
    first.save(out);
    Ball again{One{0}, One{0}};
    PhiStepper other{again, weight, velocity_verlet};
    auto rebound = bounce;
    Run second{other, again, {0, 4}, fixed(0.1), rebound};
    Reader in{out.bytes()};
    second.load(in, [&in] { in.finish(); });
    const auto report = second.finish();
    return std::tuple{report.outcome, report.t, rebound.times()};
  };
  const auto whole = play(0);
  CHECK(std::get<0>(whole) == Outcome::events_accumulate);
  const std::size_t bounces = std::get<2>(whole).size();
  for (std::size_t cut = 1; cut < bounces; ++cut) CHECK((play(cut) == whole));
}

TEST_CASE("which roots within one step are found is as event.hpp says") {
  // y = t; g has roots at the times given, changes sign at each, and is smooth.
  const auto found = [](std::vector<double> roots, double dt, bool inside, Direction direction = Direction::both) {
    One y{0};
    PhiStepper stepper{y, [](const One&) -> One { return One{1}; }, forward_euler};
    auto e = event(
        [roots](double t, const One&) {
          double g = 1;
          for (const double root : roots) g *= t - root;
          return g;
        },
        {.direction = direction, .inside = inside});
    REQUIRE(integrate(stepper, y, {0, 1}, fixed(dt), e));
    return e.times();
  };
  const auto is_near = [](const std::vector<double>& times, const std::vector<double>& roots) {
    REQUIRE(times.size() == roots.size());
    for (std::size_t k = 0; k < roots.size(); ++k) CHECK(std::abs(times[k] - roots[k]) <= 1e-12);
  };
  // One a step: all of them, without a look inside.
  is_near(found({0.13, 0.38, 0.63, 0.88}, 0.25, false), {0.13, 0.38, 0.63, 0.88});
  // Two in a step: with a look inside, in either direction.
  is_near(found({0.3, 0.7}, 1, true), {0.3, 0.7});
  is_near(found({0.3, 0.7}, 1, true, Direction::rising), {0.7});
  is_near(found({0.3, 0.7}, 1, true, Direction::falling), {0.3});
  is_near(found({0.3, 0.7}, 1, false), {});
  // Three: one at least.
  CHECK_FALSE(found({0.2, 0.5, 0.7}, 1, false).empty());
  // Ten: none is promised, as many as steps are short enough for.
  const std::vector<double> ten{0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95};
  is_near(found(ten, 1, false), {});
  is_near(found(ten, 0.0625, false), ten);
}
