// Events within steps, on flows that are known exactly.
#include <phistep/base/archive/archive.hpp>
#include <phistep/base/state/motion.hpp>
#include <phistep/run/inside/dense_output.hpp>
#include <phistep/run/observers/event_set.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "support/catch.hpp"

namespace event_set_cases {

using namespace phistep;

template <class Scalar>
using One = Eigen::Matrix<Scalar, 1, 1>;
template <class Scalar>
using Ball = Motion<One<Scalar>>;

/// The loop of event_set.hpp around a flow y(t + dt) = flow(t, dt, y), y' = slope(t, y).
template <State S, class Flow, class Slope, class... Events>
struct Loop {
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  Flow flow;
  Slope slope;
  EventSet<S, Events...> events;
  int steps = 0, resteps = 0;
  Outcome outcome = Outcome::success;

  Loop(const S&, Flow f, Slope s, Events&... e) : flow{f}, slope{s}, events{e...} {}

  /// From t to t1; returns when it ended.
  Scalar run(S& y, Scalar t, Scalar t1, Scalar dt) {
    steps = resteps = 0;
    outcome = events.begin(t, y);
    return outcome == Outcome::success ? go_on(y, t, t1, dt) : t;
  }
  Scalar go_on(S& y, Scalar t, Scalar t1, Scalar dt) {
    DenseOutput<S> dense;
    while (outcome == Outcome::success && t != t1) {
      const bool last = !(std::abs(t1 - t) > std::abs(dt));
      const Scalar h = last ? t1 - t : dt, next = last ? t1 : t + dt;
      Plain start;
      copy_blocks<S>(start, y);
      Plain end = flow(t, h, start);
      const auto slopes = [&](Plain& s0, Plain& s1) {
        s0 = slope(t, start);
        s1 = slope(next, end);
      };
      dense.begin(t, h, next, start, end, slopes);
      ++steps;
      const auto found = events.find(CompletedStep<S>(t, h, next, start, end, dense));
      outcome = found.outcome;
      if (outcome != Outcome::success) return t;
      if (!found) {
        copy_blocks<S>(y, end);
        t = next;
        continue;
      }
      const auto hit = events.refine(found, [&](Scalar to) {
        end = flow(t, to - t, start);
        return &end;
      });
      resteps += hit.resteps;
      copy_blocks<S>(y, end);
      t = hit.t;
      if (std::isfinite(hit.g)) events.look(found, t, y);
      outcome = std::isfinite(hit.g) ? events.happen(t, y) : Outcome::non_finite_event;
    }
    return t;
  }
};

/// Free fall with g = 1, exactly.
template <class Scalar>
const auto fall = [](Scalar, Scalar dt, const Ball<Scalar>& y) {
  return Ball<Scalar>{One<Scalar>{y.r(0) + dt * (y.v(0) - dt / 2)}, One<Scalar>{y.v(0) - dt}};
};
template <class Scalar>
const auto falling = [](Scalar, const Ball<Scalar>& y) {
  return Ball<Scalar>{y.v, One<Scalar>{Scalar(-1)}};
};
inline const auto height = [](const auto& y) { return y.r(0); };

template <class Scalar>
Ball<Scalar> ball(double r, double v) {
  return {One<Scalar>{static_cast<Scalar>(r)}, One<Scalar>{static_cast<Scalar>(v)}};
}

/// x' = 1, so that events are functions of time.
inline const auto clock_flow = [](double, double dt, const One<double>& y) { return One<double>{y(0) + dt}; };
inline const auto clock_slope = [](double, const One<double>&) { return One<double>{1.0}; };

template <class Scalar>
void check_bounces() {
  // The formula and the times kept are double.
  const double u = std::max<double>(std::numeric_limits<Scalar>::epsilon(), 0x1p-52) / 2;
  for (const double e : {0.9, 0.5, 0.3, 0.1, 0.01})
    for (const double dt : {0.01, 0.37, 5.0, 1e4}) {
      CAPTURE(e, dt);
      const double drop = std::sqrt(2.0), zeno = drop * (1 + e) / (1 - e);
      auto bounce = event(height, {.direction = Direction::falling},
                          [e](Scalar, Ball<Scalar>& y) { y.v *= -static_cast<Scalar>(e); });
      Ball<Scalar> y = ball<Scalar>(1, 0);
      Loop loop(y, fall<Scalar>, falling<Scalar>, bounce);
      const auto t = static_cast<double>(loop.run(y, 0, 2e4, static_cast<Scalar>(dt)));
      CHECK(loop.outcome == Outcome::events_accumulate);
      // What is left is a geometric series from the first flight that isn't sought any more: 64 probes.
      const double unseen = 64 * 64 * u * zeno;
      CHECK(std::abs(t - zeno) <= unseen / (1 - e) / e + 1e-6 * zeno * (sizeof(Scalar) == 4));
      CHECK(std::abs(static_cast<double>(y.r(0))) <= 64 * u * zeno);
      double at = drop, flight = 2 * drop, k = 1;
      for (const double bounced : bounce.times()) {
        // Each root is known to 16 roundings of t; at the next bounce they count 1/e times, because the ball leaves
        // slowly what it entered fast. Every step before rounds r and v, four roundings in t.
        const double rounding = k * 16 * (2 + 1 / e) + 4 * (at / dt + k);
        REQUIRE(std::abs(bounced - at) <= rounding * u * at);
        flight *= e;
        at += flight;
        ++k;
      }
      CHECK(loop.resteps <= 2 * static_cast<int>(bounce.times().size()));
    }
}

}  // namespace event_set_cases

using namespace event_set_cases;

#if PHISTEP_QUICK

TEMPLATE_TEST_CASE("events: a bouncing ball meets every bounce up to the Zeno time, whatever the step", "", double) {
  check_bounces<TestType>();
}

TEST_CASE("events: crossings that come in close pairs, far from t = 0, are no series that accumulates") {
  // g grazes its level: up and down again within 0.006, then a long way to the next pair. The clock is the state, so that
  // the times are known: cos(2 pi x) = 1 - 2e-4 at x = k -+ 0.003183.
  const double near = std::acos(1 - 2e-4) / (2 * std::numbers::pi);
  for (const double t0 : {0.0, 32768.0, 0x1p30})
    for (const Direction direction : {Direction::both, Direction::rising, Direction::falling})
      for (const double start : {0.5, 0.999 - near}) {
        CAPTURE(t0, static_cast<int>(direction), start);
        auto graze = event([](const auto& y) { return std::cos(2 * std::numbers::pi * y(0)) - (1 - 2e-4); },
                           {.direction = direction});
        One<double> y{start};
        Loop loop(y, clock_flow, clock_slope, graze);
        CHECK(loop.run(y, t0, t0 + 5, 0.0625) == t0 + 5);
        CHECK(loop.outcome == Outcome::success);
        std::vector<double> expected;
        for (int k = 1; k <= 5; ++k) {
          if (direction != Direction::falling) expected.push_back(t0 - start + k - near);
          if (direction != Direction::rising) expected.push_back(t0 - start + k + near);
        }
        CAPTURE(graze.times(), expected);
        REQUIRE(graze.times().size() == expected.size());
        for (std::size_t k = 0; k < expected.size(); ++k)
          CHECK(std::abs(graze.times()[k] - expected[k]) <= 64 * 0x1p-53 * (t0 + 5) + 1e-9);
      }
}

TEST_CASE("events: switchings to and fro that accumulate are told") {
  // A particle under u = -+1, switched on the curve x + c v|v| = 0 (Fuller): the times between switchings are a
  // geometric series, and g changes its sign the other way each time.
  using Scalar = double;
  const double c = 0.4446;
  double u = -1;
  auto curve =
      event([c](const auto& b) { return b.r(0) + c * b.v(0) * std::abs(b.v(0)); }, {}, [&u](Scalar, auto&) { u = -u; });
  const auto flow = [&u](Scalar, Scalar dt, const Ball<Scalar>& b) {
    return Ball<Scalar>{One<Scalar>{b.r(0) + dt * (b.v(0) + u * dt / 2)}, One<Scalar>{b.v(0) + u * dt}};
  };
  const auto slope = [&u](Scalar, const Ball<Scalar>& b) { return Ball<Scalar>{b.v, One<Scalar>{u}}; };
  for (const double dt : {0.01, 0.3}) {
    CAPTURE(dt);
    u = -1;
    Ball<Scalar> y = ball<Scalar>(1, 0);
    Loop loop(y, flow, slope, curve);
    loop.run(y, 0, 1e3, dt);
    CHECK(loop.outcome == Outcome::events_accumulate);
    CHECK(curve.times().size() > 10);
    CHECK(std::abs(y.r(0)) + std::abs(y.v(0)) <= 1e-6);
  }
}

TEST_CASE("events: which direction, and that a terminal one ends the run at its time") {
  Ball<double> y = ball<double>(0, 1);  // up at 0, down at 2
  auto up = event([](const auto& b) { return b.r(0) - 0.375; }, {.direction = Direction::rising});
  auto down = event([](const auto& b) { return b.r(0) - 0.375; }, {.direction = Direction::falling});
  auto both = event([](double, const auto& b) { return b.r(0) - 0.375; });
  auto top = event([](const auto& b) { return b.v(0); });
  auto landing = event(height, {.direction = Direction::falling, .terminal = true});
  Loop loop(y, fall<double>, falling<double>, up, down, both, top, landing);
  for (const double dt : {0.1, 0.7, 10.0}) {
    y = ball<double>(0, 1);
    const double t = loop.run(y, 0, 100, dt);
    CHECK(loop.outcome == Outcome::stopped_by_event);
    // v is 1 at the landing, r − 0.375 has slope ±1/2: 16 roundings of t, and of every step.
    CHECK(std::abs(t - 2) <= 1e-14);
    CHECK(std::abs(y.r(0)) <= 1e-14);
    REQUIRE(up.times().size() == 1);
    CHECK(std::abs(up.times()[0] - 0.5) <= 1e-14);
    REQUIRE(down.times().size() == 1);
    CHECK(std::abs(down.times()[0] - 1.5) <= 1e-14);
    CHECK(both.times() == std::vector<double>{up.times()[0], down.times()[0]});
    REQUIRE(top.times().size() == 1);
    CHECK(std::abs(top.times()[0] - 1) <= 1e-14);
  }
}

TEST_CASE("events: a run that goes on from a terminal event doesn't find it again") {
  Ball<double> y = ball<double>(1, 0);
  for (const Direction direction : {Direction::both, Direction::falling}) {
    y = ball<double>(1, 0);
    auto landing = event(height, {.direction = direction, .terminal = true});
    Loop loop(y, fall<double>, falling<double>, landing);
    const double t = loop.run(y, 0, 3, 0.1);
    REQUIRE(loop.outcome == Outcome::stopped_by_event);
    CHECK(loop.run(y, t, 3, 0.1) == 3);
    CHECK(landing.times().empty());
    // Thrown up again from there, it lands anew.
    y = ball<double>(0, 1);
    y.r(0) = -1e-17;
    CHECK(std::abs(loop.run(y, t, 5, 10) - (t + 2)) <= 1e-14);
  }
}

TEST_CASE("events: several in one step come in the order of their times, at their own states") {
  std::vector<std::string> order;
  const auto at = [&](double when, std::string name) {
    return event([when](const One<double>& y) { return y(0) - when; }, {},
                 [&order, name, when](double t, const One<double>& y) {
                   order.push_back(name);
                   CHECK(std::abs(t - when) <= 1e-14);
                   CHECK(std::abs(y(0) - when) <= 1e-14);
                 });
  };
  auto c = at(0.7, "c"), a = at(0.2, "a"), b = at(0.2000001, "b"), d = at(1.5, "d");
  One<double> y{0.0};
  Loop loop(y, clock_flow, clock_slope, c, a, b, d);
  CHECK(loop.run(y, 0, 2, 1) == 2);
  CHECK(order == std::vector<std::string>{"a", "b", "c", "d"});
  order.clear();
  CHECK(loop.run(y, 2, 0, -1.1) == 0);
  CHECK(order == std::vector<std::string>{"d", "c", "b", "a"});
}

TEST_CASE("events: at one time all handlers are called, in the order given, and one may end the run") {
  std::vector<int> order;
  const auto g = [](const One<double>& y) { return y(0) - 0.25; };
  auto first = event(g, {}, [&](double, const One<double>&) {
    order.push_back(1);
    return false;
  });
  auto second = event([g](const One<double>& y) { return -1e9 * g(y); }, {},
                      [&](double, const One<double>&) { order.push_back(2); });
  auto other = event(g, {.direction = Direction::falling}, [&](double, const One<double>&) { order.push_back(3); });
  One<double> y{0.0};
  Loop loop(y, clock_flow, clock_slope, first, second, other);
  CHECK(std::abs(loop.run(y, 0, 1, 1) - 0.25) <= 1e-15);
  CHECK(loop.outcome == Outcome::stopped_by_event);
  CHECK(order == std::vector<int>{1, 2});
}

TEST_CASE("events: where the step done again passes a second root too, that event happens with the first") {
  // The interpolant sees x = t, the step done again x = t + 3 t (1−t)/1000: the root at 0.5 moves before 0.4999.
  const auto flow = [](double, double dt, const One<double>& y) {
    return One<double>{y(0) + dt + (dt < 1 ? 0.003 * dt * (1 - dt) : 0)};
  };
  std::vector<double> happened, asked;
  auto early = event([](double t, const One<double>&) { return t - 0.4999; }, {},
                     [&](double t, const One<double>&) { happened.push_back(t); });
  auto late = event(
      [&](double t, const One<double>& y) {
        asked.push_back(t);
        return y(0) - 0.5;
      },
      {}, [&](double t, const One<double>&) { happened.push_back(t); });
  One<double> y{0.0};
  Loop loop(y, flow, clock_slope, early, late);
  loop.run(y, 0, 1, 1);
  REQUIRE(happened.size() == 2);
  CHECK(std::abs(happened[0] - 0.4999) <= 1e-15);
  CHECK(happened[1] == happened[0]);
  CHECK(std::count(asked.begin(), asked.end(), happened[0]) == 2);  // after the step, and after the handlers
}

TEST_CASE("events: the root is that of the step done again, found by two or three of them") {
  const double bend = 1e-3;
  const auto flow = [=](double, double dt, const One<double>& y) {
    return One<double>{y(0) + dt + (dt < 1 ? bend * dt * (1 - dt) : 0)};
  };
  auto half = event([](const One<double>& y) { return y(0) - 0.5; }, {.terminal = true});
  One<double> y{0.0};
  Loop loop(y, flow, clock_slope, half);
  const double t = loop.run(y, 0, 1, 1);
  CHECK(std::abs(y(0) - 0.5) <= 1e-14);
  CHECK(std::abs(t + bend * t * (1 - t) - 0.5) <= 1e-14);
  CHECK(loop.resteps <= 3);
}

TEST_CASE("events: g is evaluated once at the start, and once a step where it moves away from zero") {
  for (const bool inside : {false, true}) {
    int calls = 0, slopes = 0;
    auto count = event(
        [&](const One<double>& y) {
          ++calls;
          return 1 + y(0);
        },
        {.inside = inside});
    One<double> y{0.0};
    const auto slope = [&](double, const One<double>&) {
      ++slopes;
      return One<double>{1.0};
    };
    Loop loop(y, clock_flow, slope, count);
    CHECK(loop.run(y, 0, 10, 0.5) == 10);
    CHECK(loop.steps == 20);
    // One look beside the start tells that it isn't on a root; with `inside`, one look a step for the slope.
    CHECK(calls == 1 + 20 + 1 + (inside ? 20 : 0));
    CHECK(slopes == 2 * (inside ? 20 : 1));
  }
}

TEST_CASE("events: a g that is not finite ends the run before the step that meets it, unless an event comes first") {
  const double nan = std::nan("");
  One<double> y{0.0};
  auto g = event([=](const One<double>& x) { return x(0) < 0.55 ? 1.0 : nan; });
  Loop loop(y, clock_flow, clock_slope, g);
  CHECK(loop.run(y, 0, 1, 0.1) == Approx(0.5));
  CHECK(loop.outcome == Outcome::non_finite_event);
  y(0) = 0.7;
  loop.run(y, 0, 1, 0.1);
  CHECK(loop.outcome == Outcome::non_finite_event);
  CHECK(y(0) == 0.7);

  auto stop = event([](const One<double>& x) { return x(0) - 0.52; }, {.terminal = true});
  Loop both(y, clock_flow, clock_slope, g, stop);
  y(0) = 0;
  CHECK(both.run(y, 0, 1, 0.1) == Approx(0.52));
  CHECK(both.outcome == Outcome::stopped_by_event);

  auto poisons =
      event([](const One<double>& x) { return x(0) - 0.5; }, {}, [=](double, One<double>& x) { x(0) = nan; });
  Loop poisoned(y, clock_flow, clock_slope, poisons);
  y(0) = 0;
  poisoned.run(y, 0, 1, 0.3);
  CHECK(poisoned.outcome == Outcome::non_finite_event);
}

TEST_CASE("events: an edit by somebody else that moves g through zero is no event") {
  One<double> y{0.0};
  auto e = event([](const One<double>& x) { return x(0) - 0.5; });
  Loop loop(y, clock_flow, clock_slope, e);
  CHECK(loop.run(y, 0, 0.3, 0.1) == 0.3);
  y(0) = 2;
  CHECK(loop.events.rearm(0.3, y) == Outcome::success);
  CHECK(loop.go_on(y, 0.3, 1, 0.1) == 1);
  CHECK(e.times().empty());
}

TEST_CASE("events: a run resumed from a checkpoint goes on to the same bits") {
  const auto bounces = [](int steps_before) {
    auto bounce = event(height, {.direction = Direction::falling}, [](double, Ball<double>& b) { b.v *= -0.7; });
    Ball<double> y = ball<double>(1, 0);
    Loop loop(y, fall<double>, falling<double>, bounce);
    double t = loop.run(y, 0, 0.25 * steps_before, 0.25);
    auto resumed_bounce = bounce;
    Loop resumed(y, fall<double>, falling<double>, resumed_bounce);
    Writer out;
    out.save(loop.events);
    Reader in{out.bytes()};
    in.load(resumed.events);
    t = resumed.go_on(y, t, 20, 0.25);
    return std::tuple{t, y.r(0), y.v(0), resumed_bounce.times(), resumed.outcome};
  };
  // 0.25 is a step, so that a run cut there takes the same steps.
  const auto whole = bounces(0);
  CHECK(std::get<4>(whole) == Outcome::events_accumulate);
  CHECK(std::get<3>(whole).size() > 50);
  for (const int cut : {1, 3, 5}) CHECK((bounces(cut) == whole));
}

TEST_CASE("events: a Map of the user's array is what handlers edit") {
  double number = 0;
  using Map = Eigen::Map<One<double>>;
  Map y(&number);
  auto jump = event([](const One<double>& x) { return x(0) - 0.5; }, {}, [](double, Map& x) { x(0) += 10; });
  Loop loop(y, clock_flow, clock_slope, jump);
  CHECK(loop.run(y, 0, 1, 1) == 1);
  CHECK(std::abs(number - 11) <= 1e-15);
}

TEST_CASE("events: 1000 random pairs of crossings are met, each once and in order, whatever the steps") {
  const std::uint64_t seed = std::random_device{}();
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(random() >> 11) * 0x1p-53; };
  for (int n = 0; n < 1000; ++n) {
    const double period = uniform(0.5, 3), phase = uniform(0, period), dt = uniform(0.01, 0.24) * period;
    auto wave = event([=](const One<double>& y) { return std::sin((y(0) - phase) * std::numbers::pi / period); });
    One<double> y{0.0};
    Loop loop(y, clock_flow, clock_slope, wave);
    CAPTURE(n, period, phase, dt);
    REQUIRE(loop.run(y, 0, 20, dt) == 20);
    std::vector<double> exact;
    for (int i = 0; phase + i * period < 20; ++i) exact.push_back(phase + i * period);
    REQUIRE(wave.times().size() == exact.size());
    // The clock sums up to 20/dt roundings of 20.
    for (std::size_t i = 0; i < exact.size(); ++i)
      REQUIRE(std::abs(wave.times()[i] - exact[i]) <= (20 / dt + 32) * 20 * 0x1p-53);
  }
}

TEST_CASE("events: units of length and time that are powers of two change no bit and no count") {
  const auto bounces = [](double length, double time) {
    const double g = length / time / time;
    const auto flow = [=](double, double dt, const Ball<double>& y) {
      return Ball<double>{One<double>{y.r(0) + dt * (y.v(0) - g * dt / 2)}, One<double>{y.v(0) - g * dt}};
    };
    const auto slope = [=](double, const Ball<double>& y) { return Ball<double>{y.v, One<double>{-g}}; };
    auto bounce = event(height, {.direction = Direction::falling}, [](double, Ball<double>& y) { y.v *= -0.7; });
    Ball<double> y = ball<double>(length, 0);
    Loop loop(y, flow, slope, bounce);
    loop.run(y, 0, 100 * time, 0.1 * time);
    std::vector<double> times = bounce.times();
    for (double& t : times) t /= time;
    return std::tuple{times, loop.steps, loop.resteps};
  };
  const auto plain = bounces(1, 1);
  CHECK(std::get<0>(plain).size() > 50);
  CHECK((bounces(0x1p-40, 0x1p20) == plain));
  CHECK((bounces(0x1p60, 0x1p-30) == plain));
}

#elif PHISTEP_FULL
// event_set, every scalar.

TEMPLATE_TEST_CASE("events: a bouncing ball meets every bounce up to the Zeno time, whatever the step", "", float,
                   double, long double) {
  check_bounces<TestType>();
}

#endif
