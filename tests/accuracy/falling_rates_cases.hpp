#pragma once

// y' = −L(t) (y − g(t)) + g'(t), started on y = g, stays on g for any L > 0, and errors decay (κ = 1). L changes by up to ten
// decades: by jumps, periodically, or smoothly, and where it falls, an error that a large L has hidden is carried on. The
// unknown stands alone, or beside a constant rate of 1e6 and one of 1 in a system of three, which may be rotated.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "accuracy/truth/random.hpp"
#include "support/battery.hpp"

namespace falling_rates {

constexpr double start = 0.1, end = 16;

enum class Kind { jumps, periodic, smooth };
enum class Form { alone, beside, rotated };

/// L(t): levels between jumps, or 10^(middle + swing sin(ωt + phase)).
struct Rate {
  std::vector<double> jumps = {}, levels = {};  // at a jump, what lies behind it
  double middle = 0, swing = 0, omega = 1, phase = 0;
  [[nodiscard]] double operator()(double t) const {
    if (levels.empty()) return std::pow(10.0, middle + swing * std::sin(omega * t + phase));
    return levels[static_cast<std::size_t>(std::upper_bound(jumps.begin(), jumps.end(), t) - jumps.begin())];
  }
};
/// g(t) = middle + swing cos(ωt + phase)
struct Wave {
  double middle, swing, omega, phase;
  [[nodiscard]] double at(double t) const { return middle + swing * std::cos(omega * t + phase); }
  [[nodiscard]] double rate(double t) const { return -swing * omega * std::sin(omega * t + phase); }
};

struct Member {
  int number;
  Kind kind;
  Form form;
  Rate rate;
  double rtol;
  std::vector<Wave> waves = {};
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();

  [[nodiscard]] Eigen::VectorXd exact(double t) const {
    if (form == Form::alone) return Eigen::VectorXd::Constant(1, waves[0].at(t));
    return turn * Eigen::Vector3d(waves[0].at(t), waves[1].at(t), waves[2].at(t));
  }
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& y, double t) const {
    const double rates[]{rate(t), 1e6, 1};
    if (form == Form::alone)
      return Eigen::VectorXd::Constant(1, -rates[0] * (y[0] - waves[0].at(t)) + waves[0].rate(t));
    Eigen::Vector3d z = turn.transpose() * y;
    for (int k = 0; k < 3; ++k) {
      const Wave& wave = waves[static_cast<std::size_t>(k)];
      z[k] = -rates[k] * (z[k] - wave.at(t)) + wave.rate(t);
    }
    return turn * z;
  }
  [[nodiscard]] std::string name() const {
    static constexpr const char* kinds[]{"jumps", "periodic", "smooth"};
    static constexpr const char* forms[]{"alone", "beside 1e6", "rotated"};
    return std::to_string(number) + " (" + kinds[static_cast<int>(kind)] + ", " + forms[static_cast<int>(form)] +
           ", rtol " + figures::text(rtol) + ")";
  }
  /// An abrupt change within a step at the loosest tolerance is allowed twice as much.
  [[nodiscard]] double limit() const { return rtol > 5e-3 && kind != Kind::smooth ? 200 : 100; }
};

[[nodiscard]] inline Member member(int number) {
  truth::Random random(static_cast<std::uint64_t>(4800 + number));
  constexpr double tolerances[]{1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
  Member m{number, Kind(number % 3), Form(random.integer(0, 2)), {}, tolerances[random.integer(0, 4)]};
  if (m.kind == Kind::jumps) {
    for (int n = random.integer(2, 8); n > 0; --n) m.rate.jumps.push_back(random.uniform(0.5, 15));
    std::sort(m.rate.jumps.begin(), m.rate.jumps.end());
    for (std::size_t k = 0; k <= m.rate.jumps.size(); ++k) m.rate.levels.push_back(random.power_of_ten(-1, 9));
  } else if (m.kind == Kind::periodic) {
    const double high = random.power_of_ten(2, 9), low = random.power_of_ten(-1, 1);
    const double period = random.uniform(0.7, 6), share = random.uniform(0.2, 0.8);
    m.rate.levels.push_back(high);
    for (int k = 0; k * period < end; ++k) {
      m.rate.jumps.insert(m.rate.jumps.end(), {(k + share) * period, (k + 1) * period});
      m.rate.levels.insert(m.rate.levels.end(), {low, high});
    }
  } else {
    m.rate.swing = random.uniform(0.5, 4.5);
    m.rate.middle = random.uniform(m.rate.swing - 1, 9 - m.rate.swing);
    m.rate.omega = random.uniform(0.2, 3);
    m.rate.phase = random.uniform(0, 6);
  }
  for (int k = 0; k < 3; ++k)
    m.waves.push_back({random.chance(0.5) ? 0 : random.uniform(-1, 1), random.uniform(0.5, 1),
                       random.chance(0.5) ? 1 : random.uniform(0.3, 2), random.uniform(0, 6)});
  for (int k = 0; k < 2 && m.form == Form::rotated; ++k) {  // two reflections make a rotation
    const Eigen::Vector3d across = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    m.turn -= 2 * across * (across.transpose() * m.turn).eval();
  }
  return m;
}

/// How far a run was off, at worst at the end of a step and at worst at a sample, in rtol (1 + |g|).
struct Seen {
  bool success = false;
  std::string message;
  double nodes = 0, samples = 0;
  std::int64_t calls = 0;
};

/// `integrator(y, force, span, control, observers…)` makes the run.
[[nodiscard]] Seen run(const Member& m, bool jumps_known, bool sampled, auto integrator) {
  Seen seen;
  const auto off = [&m](double t, const Eigen::VectorXd& y) {
    const Eigen::VectorXd g = m.exact(t);
    const double error = ((y - g).array() / (1 + g.array().abs())).abs().maxCoeff() / m.rtol;
    return error <= 1e300 ? error : 1e300;
  };
  std::vector<double> marks;
  for (int k = 1; sampled && k <= 53; ++k) marks.push_back(0.3 * k);
  Eigen::VectorXd y = m.exact(start);
  const phistep::RunReport report = integrator(
      y, std::cref(m), phistep::TimeSpan<double>{start, end},
      phistep::tolerance{.rtol = m.rtol, .atol = m.rtol, .max_steps = 30'000},
      phistep::at_times(jumps_known ? m.rate.jumps : std::vector<double>{}, [](double, const Eigen::VectorXd&) {}),
      phistep::sampled(
          marks, [&](double t, const Eigen::VectorXd& now) { seen.samples = std::max(seen.samples, off(t, now)); }),
      [&](double t, const Eigen::VectorXd& now) { seen.nodes = std::max(seen.nodes, off(t, now)); });
  seen.success = report.outcome == phistep::Outcome::success;
  seen.message = report.message();
  seen.calls = report.statistics.force_calls;
  return seen;
}
[[nodiscard]] auto by(auto scheme) {
  return [scheme](Eigen::VectorXd& y, auto force, auto span, const auto& control, auto&&... observers) {
    phistep::PhiStepper stepper{y, force, scheme};
    return phistep::integrate(stepper, y, span, control, observers...);
  };
}

/// Four questions, each to every member: is the end of each step right, where the jumps are unknown and where steps end on
/// them? Are the samples as right as the ends of the steps? Does a run that succeeds still do so when samples are taken?
struct Answers {
  explicit Answers(const std::string& name)
      : unknown{name},
        known{name + ", steps end on the jumps"},
        samples{name + ", samples"},
        sampled_runs{name + ", runs with samples"} {}
  battery::Tally unknown, known, samples, sampled_runs;
  double calls_unknown = 0, calls_known = 0;
};

inline void ask(Answers& answers, int members, const std::string& scheme, auto integrator) {
  for (int number = 0; number < members; ++number) {
    const Member m = member(number);
    const std::string who = scheme + ", member " + m.name() + ": ";
    const auto verdict = [&](const Seen& seen) {
      return who + (seen.success ? "success, off by " + figures::text(seen.nodes) + " rtol" : seen.message);
    };
    const Seen plain = run(m, false, false, integrator);
    answers.unknown.count(plain.success && plain.nodes <= m.limit(), verdict(plain));
    if (m.kind != Kind::smooth) {
      const Seen cut = run(m, true, false, integrator);
      answers.known.count(cut.success && cut.nodes <= m.limit(), verdict(cut));
      answers.calls_unknown += static_cast<double>(plain.calls);
      answers.calls_known += static_cast<double>(cut.calls);
    }
    const Seen looked = run(m, false, true, integrator);
    if (plain.success) answers.sampled_runs.count(looked.success, verdict(looked));
    if (looked.success && looked.nodes <= m.limit())
      answers.samples.count(looked.samples <= m.limit(),
                            verdict(looked) + ", samples by " + figures::text(looked.samples));
  }
}
inline void tell_calls(const Answers& answers) {
  figures::told(answers.calls_known / answers.calls_unknown, answers.unknown.name,
                "force calls where steps end on the jumps, as a share of those without");
}

}  // namespace falling_rates
