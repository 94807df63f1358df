// Events in whole runs: bouncing balls, collisions with a dashpot. Every scheme, every kind of control: the stress tier.
#include <phistep/phistep.hpp>
#include <phistep/run/observers/at_times.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "accuracy/observed_order.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"
#if PHISTEP_STRESS
#include <phistep/io/checkpoint.hpp>
#endif

using namespace phistep;

namespace {

using One = Eigen::Matrix<double, 1, 1>;
using Ball = Motion<One>;
using OfBall = std::function<double(const Ball&)>;
using OfOne = std::function<double(const One&)>;
[[maybe_unused]] const OfBall height = [](const Ball& y) { return y.r(0); };
[[maybe_unused]] const shared_force::OfState<One> weight = [](const One&) -> One { return One{-9.81}; };
[[maybe_unused]] const shared_force::OfState<One> decay = [](const One& x) -> One { return -x; };

/// A ball that falls on the ground bounces with a share e of its speed.
struct Bounce {
  double e;
  void operator()(double, Ball& ball) const { ball.v *= -e; }
};
[[maybe_unused]] auto bouncing(double e) { return event(height, {.direction = Direction::falling}, Bounce{e}); }

/// The times of all bounces of a ball that falls from 1 m, by fixed steps or others.
[[maybe_unused]] void check_bounces(const RunReport& report, const std::vector<double>& times, double e) {
  const double drop = std::sqrt(2 / 9.81), zeno = drop * (1 + e) / (1 - e);
  CHECK(report.outcome == Outcome::events_accumulate);
  CHECK(std::abs(report.t - zeno) <= 1e-10);
  CHECK(times.size() > 200);
  double exact = drop, flight = 2 * drop;
  for (const double t : times) {
    REQUIRE(std::abs(t - exact) <= 1e-12);
    exact += flight *= e;
  }
}
[[maybe_unused]] void check_falling_ball(auto scheme, const auto& control) {
  const double e = 0.9;
  Ball y{One{1}, One{0}};
  PhiStepper stepper{y, weight, scheme};
  auto bounce = bouncing(e);
  const auto report = integrate(stepper, y, {0, 100}, control, bounce);
  check_bounces(report, bounce.times(), e);
}

/// Overlap r and its rate v of two spheres with m_eff v' = −k r − c v, from touching at v = 1 m/s.
struct Dashpot {
  static constexpr double mass = 0.5, k = 1e5, c = 20, rate = c / (2 * mass);
  static double frequency() { return std::sqrt(k / mass - rate * rate); }
  // r = exp(−γt) sin(ω_d t)/ω_d: separated at half a period; F = 0 where k r + c v = 0, tan(ω_d t) = −2γω_d/(ω_d²−γ²).
  static double separation_time() { return std::numbers::pi / frequency(); }
  static double separation_speed() { return std::exp(-rate * separation_time()); }
  static double zero_force_time() {
    const double w = frequency();
    return (std::numbers::pi - std::atan2(2 * rate * w, w * w - rate * rate)) / w;
  }
  static double zero_force_speed() {
    const double t = zero_force_time(), w = frequency();
    return -std::exp(-rate * t) * (std::cos(w * t) - rate / w * std::sin(w * t));
  }
  static One force(const One& r, const One& v) { return One{-k * r(0) - c * v(0)}; }
};

struct Collision {
  double t, restitution;
  Outcome outcome;
};
/// In n steps a contact, ended by g.
template <class Scheme>
Collision collide(Scheme scheme, int n, const OfBall& g) {
  Ball y{One{0}, One{1}};
  PhiStepper stepper{y, shared_force::OfMotion<One>{Dashpot::force}, scheme, mass(Dashpot::mass)};
  auto over = event(g, {.direction = Direction::falling, .terminal = true});
  const double dt = Dashpot::separation_time() / n;
  const auto report = integrate(stepper, y, {0, 1}, fixed(dt), over);
  return {report.t, -y.v(0), report.outcome};
}
[[maybe_unused]] const OfBall separated = height;
[[maybe_unused]] const OfBall no_force = [](const Ball& y) { return Dashpot::k * y.r(0) + Dashpot::c * y.v(0); };

/// In `n` steps a contact, ended by g.
using Collide = std::function<Collision(int n, const OfBall& g)>;
[[maybe_unused]] void check_orders(const Collide& run) {
  for (const bool at_zero_force : {false, true}) {
    const double t = at_zero_force ? Dashpot::zero_force_time() : Dashpot::separation_time();
    const double e = at_zero_force ? Dashpot::zero_force_speed() : Dashpot::separation_speed();
    std::vector<Collision> runs;
    for (const int n : {37, 74, 148, 296}) runs.push_back(run(n, at_zero_force ? no_force : separated));
    std::array<double, 4> of_time, of_speed;
    for (std::size_t i = 0; i < 4; ++i) {
      REQUIRE(runs[i].outcome == Outcome::stopped_by_event);
      of_time[i] = std::abs(runs[i].t - t);
      of_speed[i] = std::abs(runs[i].restitution - e);
    }
    CAPTURE(at_zero_force);
    convergence::check_order(of_time, 2);
    convergence::check_order(of_speed, 2);
  }
}
[[maybe_unused]] void check_fine(const Collide& run) {
  CHECK(std::abs(run(10000, separated).restitution - Dashpot::separation_speed()) <= 1e-8);
  CHECK(std::abs(run(10000, no_force).restitution - Dashpot::zero_force_speed()) <= 1e-8);
}
[[maybe_unused]] Collide by(auto scheme) {
  return [scheme](int n, const OfBall& g) { return collide(scheme, n, g); };
}

/// When y' = −y from 1 reaches a value: y = 1/2 at log 2.
double reached(const auto& control, double t1, double wanted) {
  One y{1};
  PhiStepper stepper{y, decay, trapezoidal};
  auto level = event(OfOne{[wanted](const One& x) { return x(0) - wanted; }}, {.terminal = true});
  const auto report = integrate(stepper, y, {0, t1}, control, level);
  CHECK(report.outcome == Outcome::stopped_by_event);
  CHECK(y(0) == Approx(wanted).epsilon(1e-14));
  return report.t;
}

}  // namespace

#if PHISTEP_FULL

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
    out.save(first);
    Ball again{One{0}, One{0}};
    PhiStepper other{again, weight, velocity_verlet};
    auto rebound = bounce;
    Run second{other, again, {0, 4}, fixed(0.1), rebound};
    Reader in{out.bytes()};
    in.load(second);
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

#elif PHISTEP_STRESS
// Events in whole runs: bouncing balls, collisions with a dashpot, runs of every kind of control.

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

#endif
