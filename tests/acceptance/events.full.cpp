// Events in whole runs: bouncing balls, collisions with a dashpot, runs of every kind of control. The quick half:
// events.test.cpp.
#include "acceptance/events_cases.hpp"

#include <phistep/io/checkpoint.hpp>
#include <phistep/run/observers/at_times.hpp>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <tuple>

TEST_CASE("a bouncing ball meets all its bounces to 1e-12, whatever the step, and the run ends at Zeno's time") {
  for (const double dt : {0.001, 0.0123, 0.5, 50.0}) {
    CAPTURE(dt);
    check_falling_ball(velocity_verlet, fixed(dt));
    check_falling_ball(trapezoidal, fixed(dt));
    check_falling_ball(midpoint, fixed(dt));
  }
  check_falling_ball(trapezoidal, tolerance{.rtol = 1e-6, .atol = 1e-9});
  check_falling_ball(velocity_verlet, tolerance{.rtol = 1e-6, .atol = 1e-9});
}

TEST_CASE("a collision with a dashpot, ended by an event: order 2 in Δt") {
  check_orders(by(trapezoidal));
  check_orders(by(midpoint));
  check_orders(by(velocity_verlet));
}

TEST_CASE("a collision with a dashpot: restitution to 1e-8, and the digits of the table") {
  check_fine(by(trapezoidal));
  check_fine(by(midpoint));
  check_fine(by(velocity_verlet));
}

TEST_CASE(
    "a particle that flies, touches and flies on: contact switched by events keeps order 2, a jump in Ψ does not") {
  // A gap of 3 mm at 1 m/s, then the contact, whose dashpot force begins with a jump.
  const double gap = 3e-3, t1 = gap + 1.5 * Dashpot::separation_time();
  const double exact = -Dashpot::separation_speed() * (t1 - gap - Dashpot::separation_time());
  const auto error = [&](int n, bool located) {
    Ball y{One{-gap}, One{1}};
    bool touching = false;
    const shared_force::OfMotion<One> force = [&](const One& r, const One& v) -> One {
      const bool on = located ? touching : r(0) > 0;
      return on ? Dashpot::force(r, v) : One{0};
    };
    PhiStepper stepper{y, force, trapezoidal, mass(Dashpot::mass)};
    auto touches = event(height, {}, [&](double, Ball&) {
      touching = !touching;
      stepper.reset();
    });
    const double dt = t1 / n;
    const auto report =
        located ? integrate(stepper, y, {0, t1}, fixed(dt), touches) : integrate(stepper, y, {0, t1}, fixed(dt));
    CHECK(report);
    if (located) CHECK(touches.times().size() == 2);
    return std::abs(y.r(0) - exact);
  };
  convergence::check_order(convergence::errors(100, [&](int n) { return error(n, true); }), 2, 0.1);
  // Unlocated, the jump costs the order, and the error depends on where it meets a step: an order on the average.
  CHECK(std::log2(error(100, false) / error(800, false)) / 3 < 1.5);
  CHECK(error(800, false) > 10 * error(800, true));
}

TEST_CASE("a first-order run stops where its solution reaches a value") {
  // Forward and backward.
  CHECK(std::abs(reached(tolerance{.rtol = 1e-8, .atol = 1e-10}, 5, 0.5) - std::log(2)) <= 1e-7);
  CHECK(std::abs(reached(tolerance{.rtol = 1e-8, .atol = 1e-10}, -5, 2.0) + std::log(2)) <= 1e-7);
}

TEST_CASE("step observers see steps that end at events, with the state before the handler's edit") {
  const auto check = [](const auto& control) {
    Ball y{One{1}, One{0}};
    PhiStepper stepper{y, weight, trapezoidal};
    auto bounce = bouncing(0.9);
    double last = 0, worst = 0;
    int at_bounce = 0;
    const auto steps = [&](const CompletedStep<Ball>& step) {
      CHECK(step.t0() == last);
      last = step.t1();
      if (std::abs(step.end().r(0)) < 1e-12) {
        ++at_bounce;
        CHECK(step.end().v(0) < 0);
      }
      for (int i = 1; i < 8; ++i) {
        const double by = i * (step.t1() - step.t0()) / 8;
        const double exact = step.start().r(0) + by * (step.start().v(0) - 9.81 * by / 2);
        worst = std::max(worst, std::abs(step.at(step.t0() + by).r(0) - exact));
      }
    };
    CHECK(integrate(stepper, y, {0, 2}, control, bounce, steps));
    CHECK(last == 2);
    CHECK(at_bounce == 3);
    CHECK(worst <= 1e-14);  // a dozen roundings of 1 m
  };
  check(fixed(0.25));
  check(tolerance{.rtol = 1e-6, .atol = 1e-9});
}

TEST_CASE("between a step's start and an event, the interpolant has the slopes of the step as it was cut") {
  One y{1};
  PhiStepper stepper{y, decay, trapezoidal};
  auto half = event(OfOne{[](const One& x) { return x(0) - 0.5; }});
  double worst = 0;
  const auto steps = [&](const CompletedStep<One>& step) {
    const double h = step.t1() - step.t0(), end = step.end()(0), start = step.start()(0);
    // Hermite's middle value from y and −y at both ends.
    const double middle = (start + end) / 2 + h / 8 * (end - start);
    worst = std::max(worst, std::abs(step.at(step.t0() + h / 2)(0) - middle));
  };
  CHECK(integrate(stepper, y, {0, 2}, tolerance{.rtol = 1e-2, .atol = 1e-3}, half, steps));
  CHECK(half.times().size() == 1);
  CHECK(worst <= 1e-5);  // the slopes are those of solves to 3 % of the tolerance
}

TEST_CASE("a step done again may end at its end after all, and the grid goes on") {
  // The interpolant sees the end's slope −5 and overshoots; forward Euler steps along the line, to the jump of g at its end.
  One y{0};
  const shared_force::OfStateAndTime<One> force = [](const One&, double t) -> One {
    return One{t < 0.05 ? 1.0 : -5.0};
  };
  PhiStepper stepper{y, force, forward_euler};
  auto jump = event(OfOne{[](const One& x) { return x(0) < 0.1 ? -1.0 : 1.0; }}, {.direction = Direction::rising});
  CHECK(integrate(stepper, y, {0, 0.3}, fixed(0.1), jump));
  REQUIRE(jump.times().size() == 1);
  CHECK(jump.times()[0] == 0.1);
}

TEST_CASE(
    "an event's function that is NaN ends the run before that step; a force that fails in the step done again, too") {
  One y{1};
  PhiStepper stepper{y, decay, trapezoidal};
  auto root = event(OfOne{[](const One& x) { return std::sqrt(x(0) - 0.5); }});
  double last = 1;
  const auto report = integrate(stepper, y, {0, 5}, fixed(0.1), root, [&](double, const One& x) { last = x(0); });
  CHECK(report.outcome == Outcome::non_finite_event);
  CHECK(report.t == Approx(0.6));
  CHECK(y(0) == last);
  CHECK(y(0) > 0.5);
  CHECK_THAT(report.message(), contains("event"));

  // The force is not finite at times that no step of the grid sees.
  One x{0};
  const shared_force::OfStateAndTime<One> force = [&](const One&, double t) -> One {
    return One{t > 0.51 && t < 0.59 ? std::nan("") : 1.0};
  };
  PhiStepper clock{x, force, backward_euler};
  auto half = event(OfOne{[&](const One& now) { return now(0) - 0.55; }});
  const auto failed = integrate(clock, x, {0, 1}, fixed(0.1), half);
  CHECK(failed.outcome == Outcome::non_finite_force);
  CHECK(x(0) == Approx(0.5));
  CHECK(failed.t == Approx(0.5));
}

TEST_CASE("a run with events and samples goes on from a checkpoint to the same bits, on a bounce too") {
  struct Scene {
    Ball y{One{1}, One{0}};
    std::vector<double> seen;
    static One pull(const One& r, const One& v) { return One{-9.81 - 0.1 * v(0) - 0.01 * r(0)}; }
  };
  // Saves after `cut` steps; from there on the run itself goes on, or one that is made anew.
  const auto play = [](const auto& control, int cut, bool resumes) {
    Scene before, after;
    const auto with_run = [&](Scene& scene, auto&& use) {
      PhiStepper stepper{scene.y, [](const One& r, const One& v) -> One { return Scene::pull(r, v); }, trapezoidal};
      auto bounce = bouncing(0.9);
      auto samples = sampled(0.05, [&](double t, const Ball& ball) {
        scene.seen.insert(scene.seen.end(), {t, ball.r(0)});
      });
      Run run{stepper, scene.y, {0, 4}, control, bounce, samples};
      use(run);
      return bounce.times();
    };
    std::ostringstream out;
    const auto all_times = with_run(before, [&](auto& run) {
      for (int n = 0; n < cut && run.advance(); ++n) {
      }
      save_checkpoint(out, run);
      if (!resumes) CHECK(run.finish());
    });
    if (!resumes) return std::tuple{all_times, before.seen, before.y.r(0), before.y.v(0)};
    const auto times = with_run(after, [&](auto& run) {
      std::istringstream in(out.str());
      load_checkpoint(in, run);
      CHECK(run.finish());
    });
    before.seen.insert(before.seen.end(), after.seen.begin(), after.seen.end());
    return std::tuple{times, before.seen, after.y.r(0), after.y.v(0)};
  };
  const auto check = [&](const auto& control) {
    const auto whole = play(control, 0, false);
    CHECK(std::get<0>(whole).size() >= 4);
    CHECK(std::get<1>(whole).size() == 2 * 81);
    for (int cut = 1; cut < 40; ++cut) CHECK((play(control, cut, true) == play(control, cut, false)));
  };
  check(fixed(0.1));
  check(tolerance{.rtol = 1e-4, .atol = 1e-6});
}
