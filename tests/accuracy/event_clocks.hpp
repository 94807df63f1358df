#pragma once

// Events on clocks of any t0 and Δt: motions that a step of the scheme follows exactly (free fall, no force at all), so that
// each event's time is known to the rounding of the clock. A member is a problem, t0, Δt and a scheme; it is right where the
// run succeeds and each event has happened once, in its order, at its time after the event before.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/truth/random.hpp"
#include "support/battery.hpp"

namespace event_clocks {

using namespace phistep;

template <class T>
using One = Eigen::Matrix<T, 1, 1>;
template <class T>
using Ball = Motion<One<T>>;
template <class T>
using Of = std::function<T(const Ball<T>&)>;
template <class T>
using Handler = std::function<bool(T, Ball<T>&)>;
template <class T>
using Force = std::function<One<T>(const One<T>&)>;

enum class Kind : int {
  bounces,  ///< a ball falls on a floor; its highest points are counted
  walls,    ///< without a force between two walls; the middle is counted
  levels,   ///< without a force through levels, each set by the handler of the one before; two events happen together
  jumps,    ///< a tooth of a saw: the handler sets r back, beyond a level that is counted on the way up
  stops,    ///< the floor ends the run, the caller turns v round and starts the next run there
};
inline constexpr std::array names{"bounces", "walls", "levels", "jumps", "stops"};
inline constexpr bool needs_force(Kind kind) { return kind == Kind::bounces || kind == Kind::stops; }

/// What happens, and how long after the event before, in periods.
struct Next {
  int which;
  double after;
};

/// [time] between one number and the next at t.
template <class T>
[[nodiscard]] T tick(T t) {
  return std::nextafter(std::abs(t), std::numeric_limits<T>::infinity()) - std::abs(t);
}

template <class T>
struct Clock {
  T t0, t1, dt, period;  ///< [time]
  [[nodiscard]] T tick_at_end() const { return tick(t1); }
  [[nodiscard]] std::string text() const {
    std::ostringstream out;
    out.precision(9);
    out << (sizeof(T) == 4 ? "float" : "double") << ", t0 " << t0 << ", dt " << dt << " = " << dt / tick_at_end()
        << " ulp, an event every " << period / dt << " dt";
    return out.str();
  }
};

template <class T>
struct Problem {
  using Log = std::vector<std::pair<int, T>>;  ///< which event, when

  Kind kind;
  Clock<T> clock;
  Ball<T> y;
  T acceleration{0};
  T level{1}, half_level{T(0.5)}, twin_level{1};
  std::array<Of<T>, 3> g;
  std::array<EventOptions, 3> options{};
  std::array<Handler<T>, 3> handler;
  std::vector<Next> cycle;
  std::size_t once = 0;  ///< the cycle is repeated without its first members
  Log log;
  double furthest = 1;  ///< |r| at most, in lengths per period

  Problem(Kind what, const Clock<T>& when) : kind{what}, clock{when} {
    const T speed = 1 / clock.period;
    y.r = One<T>{0};
    y.v = One<T>{speed};
    for (int k = 0; k < 3; ++k) {
      g[std::size_t(k)] = [](const Ball<T>&) { return T(1); };
      handler[std::size_t(k)] = [this, k](T t, Ball<T>&) { return note(k, t); };
    }
    const auto turn = [this](int k) {
      return [this, k](T t, Ball<T>& ball) {
        ball.v = -ball.v;
        return note(k, t);
      };
    };
    if (needs_force(kind)) {  // from 1 in half a period to the floor
      acceleration = -8 * speed * speed;
      y.r[0] = 1;
      y.v[0] = 0;
      g[0] = [](const Ball<T>& ball) { return ball.r[0]; };
      g[1] = [](const Ball<T>& ball) { return ball.v[0]; };
      options[0].direction = options[1].direction = Direction::falling;
      options[0].terminal = kind == Kind::stops;
      if (kind == Kind::bounces) handler[0] = turn(0);
      cycle = {{0, 0.5}, {1, 0.5}};
    } else if (kind == Kind::walls) {
      y.r[0] = T(0.25);
      g[0] = [](const Ball<T>& ball) { return ball.r[0]; };
      g[1] = [](const Ball<T>& ball) { return ball.r[0] - T(0.5); };
      g[2] = [](const Ball<T>& ball) { return 1 - ball.r[0]; };
      options[0].direction = options[2].direction = Direction::falling;
      handler[0] = turn(0);
      handler[2] = turn(2);
      cycle = {{1, 0.25}, {2, 0.5}, {1, 0.5}, {0, 0.5}, {1, 0.5}};
      once = 1;
    } else if (kind == Kind::levels) {
      furthest = 12;
      g[0] = [this](const Ball<T>& ball) { return ball.r[0] - level; };
      g[1] = [this](const Ball<T>& ball) { return ball.r[0] - half_level; };
      g[2] = [this](const Ball<T>& ball) { return ball.r[0] - twin_level; };
      const auto raise = [this](int k, T& which) {
        return [this, k, &which](T t, Ball<T>&) {
          which += 1;
          return note(k, t);
        };
      };
      handler[0] = raise(0, level);
      handler[1] = raise(1, half_level);
      handler[2] = raise(2, twin_level);
      for (EventOptions& each : options) each.direction = Direction::rising;
      cycle = {{1, 0.5}, {0, 0.5}, {2, 0}};
    } else {
      y.r[0] = -1;
      g[0] = [](const Ball<T>& ball) { return ball.r[0] - 1; };
      g[1] = [](const Ball<T>& ball) { return ball.r[0] - T(0.5); };
      for (EventOptions& each : options) each.direction = Direction::rising;
      handler[0] = [this](T t, Ball<T>& ball) {
        ball.r[0] -= 2;
        return note(0, t);
      };
      cycle = {{1, 1.5}, {0, 0.5}};
    }
  }
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;

  bool note(int which, T t) {
    log.emplace_back(which, t);
    return log.size() < 100;
  }

  /// Nothing where the events are right, else what is wrong with them.
  [[nodiscard]] std::string verdict(const RunReport& report) const {
    std::ostringstream out;
    out.precision(9);
    if (report.outcome != Outcome::success) {
      out << report.message() << " (" << log.size() << " events)";
      return out.str();
    }
    // Each end of a gap is known to 32 ulp of the clock; positions to some roundings a step.
    const double ulp = static_cast<double>(clock.tick_at_end()), period = static_cast<double>(clock.period);
    const double steps = period / static_cast<double>(clock.dt);
    const double slack =
        64 * ulp + (16 + 4 * steps) * furthest * static_cast<double>(std::numeric_limits<T>::epsilon()) * period;
    T last = clock.t0;
    std::size_t at = 0;
    for (std::size_t n = 0;; ++n) {
      const Next& next = cycle[at];
      if (++at == cycle.size()) at = once;
      const double due = next.after * period;
      if (n == log.size()) {
        const double left = static_cast<double>(clock.t1 - last);
        if (left <= due + slack) return "";
        out << "event " << n << " missed at about " << static_cast<double>(last) + due << ", " << n << " seen";
        return out.str();
      }
      const double after = static_cast<double>(log[n].second - last);
      if (log[n].first != next.which || !(std::abs(after - due) <= slack)) {
        out << "event " << n << " is number " << log[n].first << " at " << log[n].second << ", " << after / ulp
            << " ulp after the last; due: number " << next.which << ", " << due / ulp << " ulp";
        return out.str();
      }
      last = log[n].second;
    }
  }
};

template <class T, class Scheme>
RunReport run(Problem<T>& problem, Scheme scheme, const auto& control) {
  const T a = problem.acceleration;
  PhiStepper stepper{problem.y, Force<T>{[a](const One<T>&) { return One<T>{a}; }}, scheme};
  auto e0 = event(problem.g[0], problem.options[0], problem.handler[0]);
  auto e1 = event(problem.g[1], problem.options[1], problem.handler[1]);
  auto e2 = event(problem.g[2], problem.options[2], problem.handler[2]);
  T t = problem.clock.t0;
  for (;;) {
    const RunReport report = integrate(stepper, problem.y, {t, problem.clock.t1}, control, e0, e1, e2);
    if (problem.kind != Kind::stops || report.outcome != Outcome::stopped_by_event || problem.log.size() >= 100)
      return report;
    t = static_cast<T>(report.t);
    problem.y.v = -problem.y.v;
  }
}

/// A scheme by name; one that is exact without a force alone takes no fall.
template <class T>
struct Subject {
  std::string name;
  bool falls;
  std::function<RunReport(Problem<T>&)> by_fixed_steps, by_tolerance;
};
template <class T>
Subject<T> subject(const std::string& name, auto scheme, bool falls = true) {
  return {name, falls, [scheme](Problem<T>& p) { return run(p, scheme, fixed(static_cast<double>(p.clock.dt))); },
          [scheme](Problem<T>& p) {
            const double rtol = sizeof(T) == 4 ? 1e-4 : 1e-7;
            return run(p, scheme, tolerance{.rtol = rtol, .atol = rtol, .max_steps = 100000});
          }};
}
/// For schemes that keep to a fixed Δt.
template <class T>
Subject<T> fixed_subject(const std::string& name, auto scheme, bool falls = true) {
  return {name, falls, [scheme](Problem<T>& p) { return run(p, scheme, fixed(static_cast<double>(p.clock.dt))); }, {}};
}

/// How long Δt and the time between two events are, in units of the clock at t1.
enum class Range {
  wide,    ///< Δt from 64 ulp; half a period is at least 5000 ulp
  narrow,  ///< Δt from 64 ulp; half a period is 2 to 60 Δt and less than 5000 ulp
  below,   ///< Δt less than 64 ulp
};

template <class T>
Clock<T> draw(truth::Random& random, Range range) {
  const bool is_float = sizeof(T) == 4;
  for (;;) {
    Clock<T> clock{};
    const double exponent = is_float ? random.uniform(-1, 7) : random.uniform(-1, 15.2);
    const bool at_zero = range == Range::wide && random.chance(0.15);
    clock.t0 = at_zero ? T(0) : static_cast<T>(std::round(1 + std::pow(10.0, exponent)));
    const double ulp = static_cast<double>(tick(clock.t0));
    const double most = is_float ? 4 : 8;
    double count =
        range == Range::below ? random.uniform(2, 60) : 66 * random.power_of_ten(0, range == Range::wide ? most : 1);
    if (random.chance(0.2))
      count = range == Range::below ? 32 : std::max(70.0, std::exp2(std::round(std::log2(count))));
    clock.dt = static_cast<T>(at_zero ? random.power_of_ten(-6, 3) : count * ulp);
    const double steps = random.uniform(4, 120);
    clock.period = static_cast<T>(steps * static_cast<double>(clock.dt));
    const double length = static_cast<double>(clock.period) * (random.integer(6, 11) + 0.37);
    clock.t1 = static_cast<T>(static_cast<double>(clock.t0) + length);
    const double end_ulp = static_cast<double>(clock.tick_at_end()), half = static_cast<double>(clock.period) / 2;
    const double in_ulp = static_cast<double>(clock.dt) / end_ulp;
    if (range == Range::below ? in_ulp >= 62 : in_ulp < 65) continue;
    if (range == Range::wide && half < 5000 * end_ulp) continue;
    if (range == Range::narrow && half >= 5000 * end_ulp) continue;
    return clock;
  }
}

template <class T>
battery::Tally by_fixed_steps(const std::string& name, const std::vector<Subject<T>>& subjects, int members,
                              Range range, std::uint64_t seed) {
  battery::Tally tally{name};
  truth::Random random{seed};
  for (int n = 0; n < members; ++n) {
    const Subject<T>& subject = subjects[static_cast<std::size_t>(n) % subjects.size()];
    Kind kind = static_cast<Kind>(random.integer(0, 4));
    while (needs_force(kind) && !subject.falls) kind = static_cast<Kind>(random.integer(0, 4));
    Problem<T> problem{kind, draw<T>(random, range)};
    const RunReport report = subject.by_fixed_steps(problem);
    const std::string title =
        subject.name + ", " + names[static_cast<std::size_t>(kind)] + ", " + problem.clock.text() + ": ";
    if (range == Range::below) {
      const bool is_refused = report.outcome == Outcome::step_too_small && problem.log.empty();
      tally.count(is_refused, title + report.message());
    } else {
      const std::string verdict = problem.verdict(report);
      tally.count(verdict.empty(), title + verdict);
    }
  }
  return tally;
}
template <class T>
battery::Tally by_tolerance(const std::string& name, std::vector<Subject<T>> subjects, int members,
                            std::uint64_t seed) {
  std::erase_if(subjects, [](const Subject<T>& subject) { return !subject.by_tolerance; });
  battery::Tally tally{name};
  truth::Random random{seed};
  for (int n = 0; n < members; ++n) {
    const Subject<T>& subject = subjects[static_cast<std::size_t>(n) % subjects.size()];
    Kind kind = static_cast<Kind>(random.integer(0, 4));
    while (needs_force(kind) && !subject.falls) kind = static_cast<Kind>(random.integer(0, 4));
    Problem<T> problem{kind, draw<T>(random, random.chance(0.5) ? Range::narrow : Range::wide)};
    const std::string verdict = problem.verdict(subject.by_tolerance(problem));
    tally.count(verdict.empty(), subject.name + " under a tolerance, " + names[static_cast<std::size_t>(kind)] + ", " +
                                     problem.clock.text() + ": " + verdict);
  }
  return tally;
}

/// All batteries of a number type, each run once.
template <class T>
struct Batteries {
  std::string name;
  std::vector<Subject<T>> subjects;
  int members;

  /// Events at least 5000 ulp from each other.
  const battery::Tally& apart() const {
    static const battery::Tally counted = by_fixed_steps<T>(name + ", fixed steps", subjects, members, Range::wide, 1);
    return counted;
  }
  /// Events at least 128 ulp from each other, and less than 5000.
  const battery::Tally& near() const {
    static const battery::Tally counted =
        by_fixed_steps<T>(name + ", fixed steps, near to each other", subjects, members / 4, Range::narrow, 2);
    return counted;
  }
  /// What a clock can't tell is to be refused at the start.
  const battery::Tally& below() const {
    static const battery::Tally counted =
        by_fixed_steps<T>(name + ", steps below 64 ulp", subjects, members / 4, Range::below, 3);
    return counted;
  }
  const battery::Tally& with_tolerance() const {
    static const battery::Tally counted = by_tolerance<T>(name + ", a tolerance", subjects, members / 2, 4);
    return counted;
  }
};

}  // namespace event_clocks
