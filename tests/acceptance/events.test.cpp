// Events in whole runs: bouncing balls, collisions with a dashpot, runs of every kind of control.
#include <phistep/observe/at_times.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "convergence/observed_order.hpp"
#include "support/catch.hpp"

using namespace phistep;

namespace {

using One = Eigen::Matrix<double, 1, 1>;
using Ball = Motion<One>;
const auto height = [](const Ball& y) { return y.r(0); };
const auto weight = [](const One&) -> One { return One{-9.81}; };

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
template <class Scheme, class G>
Collision collide(Scheme scheme, int n, G g) {
  Ball y{One{0}, One{1}};
  PhiStepper stepper{y, [](const One& r, const One& v) -> One { return Dashpot::force(r, v); }, scheme,
                     mass(Dashpot::mass)};
  auto over = event(g, {.direction = Direction::falling, .terminal = true});
  const double dt = Dashpot::separation_time() / n;
  const auto report = integrate(stepper, y, {0, 1}, fixed(dt), over);
  return {report.t, -y.v(0), report.outcome};
}
const auto separated = [](const Ball& y) { return y.r(0); };
const auto no_force = [](const Ball& y) { return Dashpot::k * y.r(0) + Dashpot::c * y.v(0); };

}  // namespace

TEST_CASE("a bouncing ball meets all its bounces to 1e-12, whatever the step, and the run ends at Zeno's time") {
  const double drop = std::sqrt(2 / 9.81), e = 0.9, zeno = drop * (1 + e) / (1 - e);
  const auto check = [&](auto scheme, const auto& control) {
    Ball y{One{1}, One{0}};
    PhiStepper stepper{y, weight, scheme};
    auto bounce = event(height, {.direction = Direction::falling}, [e](double, Ball& ball) { ball.v *= -e; });
    const auto report = integrate(stepper, y, {0, 100}, control, bounce);
    CHECK(report.outcome == Outcome::events_accumulate);
    CHECK(std::abs(report.t - zeno) <= 1e-10);
    CHECK(bounce.times().size() > 200);
    double exact = drop, flight = 2 * drop;
    for (const double t : bounce.times()) {
      REQUIRE(std::abs(t - exact) <= 1e-12);
      exact += flight *= e;
    }
  };
  for (const double dt : {0.001, 0.0123, 0.5, 50.0}) {
    CAPTURE(dt);
    check(velocity_verlet, fixed(dt));
    check(trapezoidal, fixed(dt));
    check(midpoint, fixed(dt));
  }
  check(trapezoidal, tolerance{.rtol = 1e-6, .atol = 1e-9});
  check(velocity_verlet, tolerance{.rtol = 1e-6, .atol = 1e-9});
}

TEST_CASE("a collision with a dashpot, ended by an event: order 2 in Δt") {
  const auto orders = [](auto scheme) {
    for (const bool at_zero_force : {false, true}) {
      const double t = at_zero_force ? Dashpot::zero_force_time() : Dashpot::separation_time();
      const double e = at_zero_force ? Dashpot::zero_force_speed() : Dashpot::separation_speed();
      std::vector<Collision> runs;
      for (const int n : {37, 74, 148, 296})
        runs.push_back(at_zero_force ? collide(scheme, n, no_force) : collide(scheme, n, separated));
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
  };
  orders(trapezoidal);
  orders(midpoint);
  orders(velocity_verlet);
}

TEST_CASE("a collision with a dashpot: restitution to 1e-8, and the digits of the table") {
  CHECK(Dashpot::separation_time() == Approx(7.031850e-3).epsilon(1e-6));
  CHECK(Dashpot::separation_speed() == Approx(0.868804629).epsilon(1e-9));
  CHECK(Dashpot::zero_force_time() == Approx(6.831583e-3).epsilon(1e-6));
  CHECK(Dashpot::zero_force_speed() == Approx(0.872291467).epsilon(1e-9));
  const auto fine = [](auto scheme, int n) {
    CHECK(std::abs(collide(scheme, n, separated).restitution - Dashpot::separation_speed()) <= 1e-8);
    CHECK(std::abs(collide(scheme, n, no_force).restitution - Dashpot::zero_force_speed()) <= 1e-8);
  };
  fine(trapezoidal, 10000);
  fine(midpoint, 10000);
  fine(velocity_verlet, 10000);
}

TEST_CASE(
    "a particle that flies, touches and flies on: contact switched by events keeps order 2, a jump in Ψ does not") {
  // A gap of 3 mm at 1 m/s, then the contact, whose dashpot force begins with a jump.
  const double gap = 3e-3, t1 = gap + 1.5 * Dashpot::separation_time();
  const double exact = -Dashpot::separation_speed() * (t1 - gap - Dashpot::separation_time());
  const auto error = [&](int n, bool located) {
    Ball y{One{-gap}, One{1}};
    bool touching = false;
    PhiStepper stepper{y,
                       [&](const One& r, const One& v) -> One {
                         const bool on = located ? touching : r(0) > 0;
                         return on ? Dashpot::force(r, v) : One{0};
                       },
                       trapezoidal, mass(Dashpot::mass)};
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
  // y' = −y from 1: y = 1/2 at log 2, in each kind of control, forward and backward.
  const auto reached = [](const auto& control, double t1, double wanted) {
    One y{1};
    PhiStepper stepper{y, [](const One& x) -> One { return -x; }, trapezoidal};
    auto level = event([wanted](const One& x) { return x(0) - wanted; }, {.terminal = true});
    const auto report = integrate(stepper, y, {0, t1}, control, level);
    CHECK(report.outcome == Outcome::stopped_by_event);
    CHECK(y(0) == Approx(wanted).epsilon(1e-14));
    return report.t;
  };
  // Error of the rule: t Δt²/12.
  CHECK(std::abs(reached(fixed(1e-3), 5, 0.5) - std::log(2)) <= 1e-7);
  CHECK(std::abs(reached(fixed(1e-3), -5, 2.0) + std::log(2)) <= 1e-7);
  CHECK(std::abs(reached(tolerance{.rtol = 1e-8, .atol = 1e-10}, 5, 0.5) - std::log(2)) <= 1e-7);
  CHECK(std::abs(reached(tolerance{.rtol = 1e-8, .atol = 1e-10}, -5, 2.0) + std::log(2)) <= 1e-7);
}

TEST_CASE("after an event a run keeps to its grid, and meets the given times") {
  Ball y{One{1}, One{0}};
  PhiStepper stepper{y, weight, velocity_verlet};
  auto bounce = event(height, {.direction = Direction::falling}, [](double, Ball& ball) { ball.v *= -0.9; });
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

TEST_CASE("step observers see steps that end at events, with the state before the handler's edit") {
  const auto check = [](const auto& control) {
    Ball y{One{1}, One{0}};
    PhiStepper stepper{y, weight, trapezoidal};
    auto bounce = event(height, {.direction = Direction::falling}, [](double, Ball& ball) { ball.v *= -0.9; });
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
  PhiStepper stepper{y, [](const One& x) -> One { return -x; }, trapezoidal};
  auto half = event([](const One& x) { return x(0) - 0.5; });
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
  // The interpolant sees the end's slope −5 and overshoots; forward Euler steps along the line, to the jump of g at 0.099.
  One y{0};
  PhiStepper stepper{y, [](const One&, double t) -> One { return One{t < 0.05 ? 1.0 : -5.0}; }, forward_euler};
  auto jump = event([](const One& x) { return x(0) < 0.099 ? -1.0 : 1.0; }, {.direction = Direction::rising});
  CHECK(integrate(stepper, y, {0, 0.3}, fixed(0.1), jump));
  REQUIRE(jump.times().size() == 1);
  CHECK(jump.times()[0] == 0.1);
}

TEST_CASE(
    "an event's function that is NaN ends the run before that step; a force that fails in the step done again, too") {
  One y{1};
  PhiStepper stepper{y, [](const One& x) -> One { return -x; }, trapezoidal};
  auto root = event([](const One& x) { return std::sqrt(x(0) - 0.5); });
  double last = 1;
  const auto report = integrate(stepper, y, {0, 5}, fixed(0.1), root, [&](double, const One& x) { last = x(0); });
  CHECK(report.outcome == Outcome::non_finite_event);
  CHECK(report.t == Approx(0.6));
  CHECK(y(0) == last);
  CHECK(y(0) > 0.5);
  CHECK_THAT(report.message(), contains("event"));

  // The force is not finite at times that no step of the grid sees.
  One x{0};
  PhiStepper clock{x, [&](const One&, double t) -> One { return One{t > 0.51 && t < 0.59 ? std::nan("") : 1.0}; },
                   backward_euler};
  auto half = event([&](const One& now) { return now(0) - 0.55; });
  const auto failed = integrate(clock, x, {0, 1}, fixed(0.1), half);
  CHECK(failed.outcome == Outcome::non_finite_force);
  CHECK(x(0) == Approx(0.5));
  CHECK(failed.t == Approx(0.5));
}

TEST_CASE("an event that throws leaves a state of the run") {
  One y{1};
  PhiStepper stepper{y, [](const One& x) -> One { return -x; }, trapezoidal};
  auto bad = event([](const One& x) -> double { return x(0) < 0.5 ? throw std::runtime_error("no") : 1.0; });
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
    PhiStepper stepper{y, [](const One& r) -> One { return -r; }, velocity_verlet};
    auto never = event([](const Ball& ball) { return ball.r(0) + 10; }, {.inside = false});
    const auto report =
        watched ? integrate(stepper, y, {0, 10}, fixed(0.01), never) : integrate(stepper, y, {0, 10}, fixed(0.01));
    CHECK(report);
    return report.statistics.force_calls;
  };
  // Two for the slopes at the start, where one look tells that the run doesn't stand on the root.
  CHECK(calls(true) == calls(false) + 2);
}

TEST_CASE("a run with events and samples goes on from a checkpoint to the same bits, on a bounce too") {
  struct Scene {
    Ball y{One{1}, One{0}};
    std::vector<double> seen;
    static One pull(const One& r, const One& v) { return One{-9.81 - 0.1 * v(0) - 0.01 * r(0)}; }
  };
  const auto play = [](const auto& control, int cut) {
    Scene before, after;
    const auto with_run = [&](Scene& scene, auto&& use) {
      PhiStepper stepper{scene.y, [](const One& r, const One& v) -> One { return Scene::pull(r, v); }, trapezoidal};
      auto bounce = event(height, {.direction = Direction::falling}, [](double, Ball& ball) { ball.v *= -0.9; });
      auto samples = sampled(0.05, [&](double t, const Ball& ball) {
        scene.seen.insert(scene.seen.end(), {t, ball.r(0)});
      });
      Run run{stepper, scene.y, {0, 4}, control, bounce, samples};
      use(run);
      return bounce.times();
    };
    Writer out;
    static_cast<void>(with_run(before, [&](auto& run) {
      for (int n = 0; n < cut && run.advance(); ++n) {
      }
      run.save(out);
      out.finish();
    }));
    const auto times = with_run(after, [&](auto& run) {
      Reader in{out.bytes()};
      run.load(in, [&in] { in.finish(); });
      CHECK(run.finish());
    });
    before.seen.insert(before.seen.end(), after.seen.begin(), after.seen.end());
    return std::tuple{times, before.seen, after.y.r(0), after.y.v(0)};
  };
  const auto check = [&](const auto& control) {
    const auto whole = play(control, 0);
    CHECK(std::get<0>(whole).size() >= 4);
    CHECK(std::get<1>(whole).size() == 2 * 81);
    for (int cut = 1; cut < 40; ++cut) CHECK((play(control, cut) == whole));
  };
  check(fixed(0.1));
  check(tolerance{.rtol = 1e-4, .atol = 1e-6});
}

TEST_CASE("how soon events follow each other is part of a checkpoint") {
  const auto play = [](std::size_t cut) {
    Ball y{One{1}, One{0}};
    PhiStepper stepper{y, weight, velocity_verlet};
    auto bounce = event(height, {.direction = Direction::falling}, [](double, Ball& ball) { ball.v *= -0.3; });
    Run first{stepper, y, {0, 4}, fixed(0.1), bounce};
    while (bounce.times().size() < cut && first.advance()) {
    }
    Writer out;
    first.save(out);
    out.finish();
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
