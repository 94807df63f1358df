#pragma once

// A load that jumps at times the user knows: y' = λy + load, or r'' = −ω²r + load, where the load is a straight line between
// two jumps. Both have closed forms. The user can say where the jumps are in several ways, and all should be as good as
// stepping from jump to jump by new steppers, each with a load that knows of no jump.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/truth/random.hpp"
#include "support/battery.hpp"

namespace jumps {

using Vec = Eigen::Vector2d;
using Complex = std::complex<double>;

enum class Way {
  pieces,          // new steppers, loads without jumps
  at_times,        // the load is a function of time, steps end on the jumps
  row_of_runs,     // the same load, a run ends on each jump
  handler,         // at_times switches the load
  handler_resets,  // and calls reset()
  observer,        // what looks at each step switches the load
  observer_resets
};
[[nodiscard]] inline std::string name(Way way) {
  constexpr const char* names[]{"runs of new steppers",       "steps end on the jumps", "a run ends on each jump",
                                "at_times switches the load", "at_times, with reset()", "an observer switches the load",
                                "an observer, with reset()"};
  return names[static_cast<int>(way)];
}

struct Line {
  double since;
  Vec level, slope;
  [[nodiscard]] Vec at(double t) const { return level + (t - since) * slope; }
};
/// The load as the force sees it: a function of time, or what the user has switched on.
struct Loads {
  std::vector<double> jumps = {};
  std::vector<Line> lines = {};  // one more than jumps
  bool of_time = true;
  bool before = false;  // at a jump, a function of time gives what lies before it, else what lies behind it
  std::size_t now = 0;  // the line switched on
  [[nodiscard]] Vec at(double t) const {
    if (!of_time) return lines[now].at(t);
    const auto next =
        before ? std::lower_bound(jumps.begin(), jumps.end(), t) : std::upper_bound(jumps.begin(), jumps.end(), t);
    return lines[static_cast<std::size_t>(next - jumps.begin())].at(t);
  }
};

/// y' = λy + load, y a complex number.
struct Turning {
  using State = Vec;
  struct Force {
    const Loads* loads;
    Complex lambda;
    [[nodiscard]] Vec operator()(const Vec& y, double t) const {
      const Complex rate = lambda * Complex{y[0], y[1]};
      return Vec(rate.real(), rate.imag()) + loads->at(t);
    }
  };
  Complex lambda{};
  [[nodiscard]] Force force(const Loads& loads) const { return {&loads, lambda}; }
  [[nodiscard]] static State start() { return Vec(1, 0.3); }
  [[nodiscard]] State flow(const State& y, const Line& line, double h) const {
    const Complex slope = Complex{line.slope[0], line.slope[1]} / -lambda;
    const Complex level = (slope - Complex{line.level[0], line.level[1]}) / lambda;
    const Complex z = level + slope * h + (Complex{y[0], y[1]} - level) * std::exp(lambda * h);
    return Vec(z.real(), z.imag());
  }
  [[nodiscard]] static double distance(const State& a, const State& b) {
    return ((a - b).array() / (1 + b.array().abs())).abs().maxCoeff();
  }
};
/// r'' = −ω²r + load
struct Swinging {
  using State = phistep::Motion<Vec>;
  struct Force : phistep::ForceTerm {
    static constexpr bool uses_velocity = false, uses_time = true;
    const Loads* loads;
    double k;
    Force(const Loads* of, double stiffness) : loads{of}, k{stiffness} {}
    void add(double t, const auto& y, auto& out) const { out.force += loads->at(t) - k * y.r; }
  };
  double omega = 1;
  [[nodiscard]] Force force(const Loads& loads) const { return {&loads, omega * omega}; }
  [[nodiscard]] static State start() { return {Vec(1, 0.3), Vec(0, -0.5)}; }
  [[nodiscard]] State flow(const State& y, const Line& line, double h) const {
    const Vec slope = line.slope / (omega * omega), level = line.level / (omega * omega);
    const Vec a = y.r - level, b = (y.v - slope) / omega;
    const double c = std::cos(omega * h), s = std::sin(omega * h);
    return {level + slope * h + a * c + b * s, slope + omega * (b * c - a * s)};
  }
  [[nodiscard]] static double distance(const State& a, const State& b) {
    return std::max(Turning::distance(a.r, b.r), Turning::distance(a.v, b.v));
  }
};

template <class Problem>
struct Member {
  int number;
  double unit, end;
  Problem problem;
  Loads loads;
  [[nodiscard]] auto exact() const {
    auto y = Problem::start();
    for (std::size_t k = 0; k < loads.lines.size(); ++k) {
      const double until = k < loads.jumps.size() ? loads.jumps[k] : end;
      y = problem.flow(y, loads.lines[k], until - loads.lines[k].since);
    }
    return y;
  }
};
/// From 0 to 8 units of about the given length, with two to five jumps: on multiples of the unit, or anywhere.
template <class Problem>
[[nodiscard]] Member<Problem> member(int number, double about, bool on_grid) {
  truth::Random random(static_cast<std::uint64_t>(4900 + number));
  const double unit = about * (random.chance(0.3) ? 1 : random.uniform(0.8, 1.1));
  Member<Problem> m{number, unit, 8 * unit, {}, {}};
  const double speed = random.uniform(0.5, 1.5);
  if constexpr (std::is_same_v<Problem, Turning>) m.problem.lambda = {-random.uniform(0, 0.4), speed};
  else m.problem.omega = speed;
  std::vector<double>& times = m.loads.jumps;
  for (int n = random.integer(2, 5); n > 0; --n)
    times.push_back(on_grid ? random.integer(1, 7) * unit : random.uniform(0.4, 7.6) * unit);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  Vec level(random.uniform(-1, 1), random.uniform(-1, 1));
  for (std::size_t k = 0; k <= times.size(); ++k) {
    m.loads.lines.push_back(
        {k == 0 ? 0.0 : times[k - 1], level, Vec(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5))});
    for (const int i : {0, 1}) level[i] += (level[i] > 0 ? -1 : 1) * random.uniform(0.7, 1.7);
  }
  m.loads.before = random.chance(0.5);
  return m;
}

struct Seen {
  bool success = true;
  std::string message;
  double error = 0;
  std::int64_t tries = 0;  // steps, and those rejected or failed
};

template <class Problem>
[[nodiscard]] Seen run(const Member<Problem>& m, Way way, auto scheme, const auto& control) {
  using State = typename Problem::State;
  Loads loads = m.loads;
  loads.of_time = way == Way::at_times || way == Way::row_of_runs;
  const bool in_pieces = way == Way::pieces || way == Way::row_of_runs;
  const bool by_handler = way == Way::handler || way == Way::handler_resets;
  const bool by_observer = way == Way::observer || way == Way::observer_resets;
  const bool resets = way == Way::handler_resets || way == Way::observer_resets;

  Seen seen;
  State y = Problem::start();
  const auto go = [&](auto& stepper, double t0, double t1) {
    const phistep::RunReport report = phistep::integrate(
        stepper, y, {t0, t1}, control,
        phistep::at_times(in_pieces || by_observer ? std::vector<double>{} : loads.jumps,
                          [&](double, const State&) {
                            if (!by_handler) return;
                            ++loads.now;
                            if (resets) stepper.reset();
                          }),
        [&](double t, const State&) {
          if (!by_observer || loads.now >= loads.jumps.size() || t < loads.jumps[loads.now] - 1e-3 * m.unit) return;
          ++loads.now;
          if (resets) stepper.reset();
        });
    if (!report && seen.success) seen.message = report.message();
    seen.success = seen.success && report.outcome == phistep::Outcome::success;
    seen.tries += report.statistics.steps + report.statistics.failed_steps;
  };
  phistep::PhiStepper stepper{y, m.problem.force(loads), scheme};
  for (std::size_t k = 0; k < (in_pieces ? loads.lines.size() : 1); ++k) {
    const double t0 = in_pieces ? loads.lines[k].since : 0;
    const double t1 = in_pieces && k < loads.jumps.size() ? loads.jumps[k] : m.end;
    if (way == Way::pieces) {
      loads.now = k;
      phistep::PhiStepper fresh{y, m.problem.force(loads), scheme};
      go(fresh, t0, t1);
    } else {
      go(stepper, t0, t1);
    }
  }
  seen.error = seen.success ? Problem::distance(y, m.exact()) : 1;
  return seen;
}

/// At fixed Δt, on two halvings of Δt: the scheme's order, or rounding.
template <class Problem>
void order_survives(battery::Tally& tally, int number, Way way, const char* name, auto scheme, double order, int steps,
                    double unit = 1) {
  const bool by_observer = way == Way::observer || way == Way::observer_resets;
  const auto m = member<Problem>(number, unit, by_observer || number % 3 != 0);
  double errors[3];
  std::string message;
  for (const int k : {0, 1, 2}) {
    const Seen seen = run(m, way, scheme, phistep::fixed(m.unit / (steps << k)));
    errors[k] = seen.error;
    if (!seen.success) message = seen.message;
  }
  const double observed = std::log2(errors[0] / errors[2]) / 2;
  const std::string found = "order " + figures::text(observed) + ", error " + figures::text(errors[2]);
  tally.count(message.empty() && (observed >= 0.75 * order || errors[2] <= 1e-12),
              std::string(name) + ", member " + std::to_string(number) + ": " + (message.empty() ? found : message));
}

/// Under a tolerance: errors within 20 rtol, and no more than 1.5 times the tries of runs of new steppers.
struct Answers {
  battery::Tally errors, tries;
};
inline void are_right(const Answers& answers) {
  battery::at_most(0, answers.errors);
  battery::at_most(0, answers.tries);
}
template <class Problem>
void tolerance_holds(Answers& answers, int number, Way way, const char* name, auto scheme, double tightest,
                     double unit = 1) {
  truth::Random random(static_cast<std::uint64_t>(number));
  const double rtol = random.power_of_ten(tightest, -3);
  const auto m = member<Problem>(number, unit, number % 3 != 0);
  const phistep::tolerance control{.rtol = rtol, .atol = rtol, .max_steps = 100'000};
  const Seen plain = run(m, Way::pieces, scheme, control), seen = run(m, way, scheme, control);
  const std::string who =
      std::string(name) + ", member " + std::to_string(number) + ", rtol " + figures::text(rtol) + ": ";
  answers.errors.count(
      seen.success && seen.error <= 20 * rtol,
      who + (seen.success ? "success, off by " + figures::text(seen.error / rtol) + " rtol" : seen.message));
  answers.tries.count(2 * seen.tries <= 3 * plain.tries,
                      who + std::to_string(seen.tries) + " tries, " + std::to_string(plain.tries) + " by new steppers");
}

}  // namespace jumps
