#pragma once

// Forces that are defined on one side of a bound: NaN beyond it, or an exception. The solution touches the bound, comes near
// to it, or starts near to it. A member is such a problem, a scheme and its steps. It is wrong where the run ends at a state
// beyond the bound, whatever it calls that; where it ends by too many steps; where it calls success what is far off; and,
// where the solution stays inside and steps may be shortened, where it fails.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/truth/random.hpp"
#include "support/battery.hpp"

namespace force_bounds {

using namespace phistep;

inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// What a state is measured against.
template <class S, class Force>
struct Problem {
  std::string name;
  S y;
  double t1, scale;  ///< of time, and of the first component
  Force force;
  std::function<bool(const S&, double)> is_inside;  ///< the force is defined there
  double exact = not_a_number;                      ///< of the first component at t1; NaN where not known
  bool touches = false;
  int fewest_steps = 5;  ///< by a fixed Δt
};
inline double first(const Eigen::VectorXd& y) { return y[0]; }
template <class V>
double first(const Motion<V>& y) {
  return y.r[0];
}

struct Control {
  bool is_fixed;
  double dt = 0, rtol = 0, atol = -1;
  [[nodiscard]] std::string text() const {
    std::ostringstream out;
    if (is_fixed) out << "dt " << dt;
    else
      out << "rtol " << rtol << (atol < 0 ? ", no atol" : ", atol ")
          << (atol < 0 ? "" : std::to_string(atol / rtol) + " rtol");
    return out.str();
  }
};
/// f(fixed(…)) or f(tolerance{…})
template <class F>
RunReport with_control(const Control& control, F&& f) {
  constexpr std::int64_t most = 50000;
  if (control.is_fixed) return f(fixed(control.dt, {.max_steps = most}));
  tolerance tol{.rtol = control.rtol, .max_steps = most};
  if (control.atol >= 0) tol.atol = control.atol;
  return f(tol);
}

template <class P>
struct Subject {
  std::string name;
  std::function<RunReport(P&, const Control&)> run;
  int digits = 9;        ///< the tightest rtol: what takes thousands of steps anyway is not asked for
  bool asks_end = true;  ///< at a fixed Δt it asks the force at a step's end before it accepts it
};
template <class P>
Subject<P> subject(const std::string& name, auto scheme, int digits = 9, bool asks_end = true) {
  return {
      name,
      [scheme](P& problem, const Control& control) {
        PhiStepper stepper{problem.y, problem.force, scheme};
        return with_control(control, [&](const auto& c) { return integrate(stepper, problem.y, {0, problem.t1}, c); });
      },
      digits, asks_end};
}

/// Right where empty; `refused` where it is right to fail and it did.
template <class P>
std::string verdict(P& problem, const Subject<P>& subject, const Control& control, bool& refused) {
  std::ostringstream out;
  RunReport report{};
  bool threw = false;
  try {
    report = subject.run(problem, control);
  } catch (const std::out_of_range&) {
    threw = true;
  }
  const double y = first(problem.y);
  if (!problem.is_inside(problem.y, report.t)) out << "stands beyond the bound, y = " << y << "; ";
  if (!threw && report.outcome == Outcome::too_many_steps) out << "too many steps; ";
  if (!threw && report.outcome == Outcome::success && !control.is_fixed && !std::isnan(problem.exact) &&
      !(std::abs(y - problem.exact) <= std::max(0.02, 100 * control.rtol) * problem.scale))
    out << "far off, " << y << " for " << problem.exact << "; ";
  refused = threw || report.outcome != Outcome::success;
  if (refused && !control.is_fixed && !problem.touches) out << "it stays inside; ";
  if (out.str().empty()) return {};
  out << (threw ? "exception" : report.message());
  return out.str();
}

/// @param draw  draws a problem, of those that touch the bound or of the others
template <class P>
battery::Tally run(const std::string& name, const std::vector<Subject<P>>& subjects, int members, std::uint64_t seed,
                   bool by_fixed_steps, const std::function<P(truth::Random&)>& draw) {
  battery::Tally tally{name};
  truth::Random random{seed};
  int refused = 0;
  for (int n = 0; n < members; ++n) {
    const Subject<P>& subject = subjects[static_cast<std::size_t>(n) % subjects.size()];
    P problem = draw(random);
    Control control{.is_fixed = by_fixed_steps};
    control.dt = problem.t1 / (problem.fewest_steps * random.integer(1, 40));
    control.rtol = std::pow(10.0, -random.integer(3, subject.digits));
    if (random.chance(0.5)) control.atol = control.rtol * problem.scale * std::pow(10.0, -random.integer(0, 4));
    bool is_refused = false;
    const std::string found = verdict(problem, subject, control, is_refused);
    refused += is_refused && found.empty() ? 1 : 0;
    tally.count(found.empty(), subject.name + ", " + problem.name + ", " + control.text() + ": " + found);
  }
  figures::told(refused, name, "refused, the state inside");
  return tally;
}

// ---- first order ----

using Vec = Eigen::VectorXd;
using Flow = Problem<Vec, std::function<Vec(const Vec&, double)>>;

inline Vec one(double x) { return Vec::Constant(1, x); }
inline Vec two(double x, double y) { return Eigen::Vector2d{x, y}; }
inline bool not_negative(const Vec& y, double) { return y.allFinite() && y.minCoeff() >= 0; }

/// A table of 1 − x² on 0 … 1, linear between its entries.
inline double in_table(double x, bool throws) {
  if (!(x >= 0 && x <= 1)) return throws ? throw std::out_of_range("the table ends") : not_a_number;
  constexpr double entries = 16;
  const double low = std::min(std::floor(x * entries), entries - 1) / entries, high = low + 1 / entries;
  const double at_low = 1 - low * low, at_high = 1 - high * high;
  return at_low + (at_high - at_low) * (x - low) * entries;
}

/// A problem whose solution touches its bound, or ends there.
inline Flow draw_touching(truth::Random& random) {
  const double k = random.power_of_ten(-3, 3), size = random.power_of_ten(-4, 4);
  const double share = std::vector{1.0, 1.0001, 1.5, 3.0}[static_cast<std::size_t>(random.integer(0, 3))];
  Flow p;
  p.touches = true;
  p.scale = size;
  switch (random.integer(0, 5)) {
    case 0: {
      p.name = "a tank runs empty";
      p.y = one(size);
      p.force = [k](const Vec& y, double) { return one(-k * std::sqrt(y[0])); };
      p.t1 = share * 2 * std::sqrt(size) / k;
      p.is_inside = not_negative;
      p.exact = 0;
      break;
    }
    case 1: {
      p.name = "two tanks run empty";
      const double q = k * random.uniform(0.3, 3);
      p.y = two(size, 0.1 * size);
      p.force = [k, q](const Vec& y, double) {
        return two(-k * std::sqrt(y[0]), k * std::sqrt(y[0]) - q * std::sqrt(y[1]));
      };
      p.t1 = share * 2 * std::sqrt(size) / k;
      p.is_inside = not_negative;
      p.exact = 0;
      break;
    }
    case 2: {
      p.name = "to the top of a circle";
      p.scale = 1;
      p.y = one(0);
      p.force = [k](const Vec& y, double) { return one(k * std::sqrt(1 - y[0] * y[0])); };
      p.t1 = share * 1.5707963267948966 / k;
      p.is_inside = [](const Vec& y, double) { return std::abs(y[0]) <= 1; };
      p.exact = 1;
      break;
    }
    case 3: {
      p.name = "a power of y runs out";
      const double power = random.uniform(0.3, 0.9);
      p.y = one(size);
      p.force = [k, power](const Vec& y, double) { return one(-k * std::pow(y[0], power)); };
      p.t1 = share * std::pow(size, 1 - power) / (k * (1 - power));
      p.is_inside = not_negative;
      p.exact = 0;
      break;
    }
    case 4: {
      p.name = "a reactant runs out";
      p.y = two(size, size * random.uniform(1, 1.9));  // the second first
      p.force = [k](const Vec& y, double) {
        const double rate = k * std::sqrt(y[0]) * std::sqrt(y[1]);
        return two(-rate, -2 * rate);
      };
      p.t1 = share * 10 / k;
      p.is_inside = not_negative;
      p.exact = size - p.y[1] / 2;
      break;
    }
    default: {
      const bool throws = random.chance(0.5);
      p.name = throws ? "a table ends at rest, by an exception" : "a table ends at rest";
      p.scale = 1;
      p.y = one(random.uniform(0, 0.9));
      p.force = [k, throws](const Vec& y, double) { return one(k * in_table(y[0], throws)); };
      p.t1 = 10 * share / k;
      p.is_inside = [](const Vec& y, double) { return y[0] >= 0 && y[0] <= 1; };
      p.exact = 1;
      break;
    }
  }
  return p;
}

/// y' = k (1 + e log(1 − y)) from 0: at rest at 1 − exp(−1/e).
inline Flow near_a_logarithm(double k, double e) {
  Flow p;
  p.name = "at rest near to a logarithm's end, " + figures::text(e);
  p.scale = 1;
  p.y = one(0);
  p.force = [k, e](const Vec& y, double) { return one(k * (1 + e * std::log1p(-y[0]))); };
  p.t1 = 10 / k;
  p.is_inside = [](const Vec& y, double) { return y[0] < 1; };
  p.exact = 1 - std::exp(-1 / e);
  return p;
}

/// A problem whose solution stays inside.
inline Flow draw_inside(truth::Random& random) {
  const double k = random.power_of_ten(-3, 3), size = random.power_of_ten(-4, 4);
  Flow p;
  p.scale = size;
  switch (random.integer(0, 4)) {
    case 0: {
      const double share = std::vector{0.7, 0.9, 0.97}[static_cast<std::size_t>(random.integer(0, 2))];
      p.name = "a tank, not yet empty";
      p.y = one(size);
      p.force = [k](const Vec& y, double) { return one(-k * std::sqrt(y[0])); };
      p.t1 = share * 2 * std::sqrt(size) / k;
      p.is_inside = not_negative;
      p.exact = size * (1 - share) * (1 - share);
      break;
    }
    case 1: {
      const double share = std::vector{0.5, 0.8, 0.95}[static_cast<std::size_t>(random.integer(0, 2))];
      p.name = "not yet to the top of a circle";
      p.scale = 1;
      p.y = one(0);
      p.force = [k](const Vec& y, double) { return one(k * std::sqrt(1 - y[0] * y[0])); };
      p.t1 = share * 1.5707963267948966 / k;
      p.is_inside = [](const Vec& y, double) { return std::abs(y[0]) <= 1; };
      p.exact = std::sin(k * p.t1);
      break;
    }
    case 2: {
      p = near_a_logarithm(k, random.uniform(0.1, 0.3));
      break;
    }
    case 3: {
      p.name = "away from a logarithm's end";
      p.scale = 1;
      p.y = one(1 - random.power_of_ten(-6, -1));
      p.force = [k](const Vec& y, double) { return one(k * std::log1p(-y[0])); };
      p.t1 = 30 / k;
      p.is_inside = [](const Vec& y, double) { return y[0] < 1; };
      p.exact = 0;
      break;
    }
    default: {
      // In √y = w: w' = (a(t) − k w)/2, which a swinging inflow keeps above what it is at least.
      const double least = random.uniform(0.2, 0.5), w = random.uniform(0.2, 5) * k;
      p.name = "a tank with an inflow that swings";
      p.scale = 1;
      p.y = one(1);
      p.force = [k, least, w](const Vec& y, double t) {
        return one(k * (least + (1 - least) * std::pow(std::cos(w * t), 2) - std::sqrt(y[0])));
      };
      p.t1 = 20 / k;
      p.is_inside = not_negative;
      break;
    }
  }
  return p;
}

/// The batteries of a list of schemes, each run once.
class Batteries {
 public:
  Batteries(const std::string& title, const std::vector<Subject<Flow>>& all, int count)
      : name_{title}, subjects_{all}, members_{count} {}

  const battery::Tally& touching() const {
    static const battery::Tally counted =
        run<Flow>(name_ + ", a tolerance, a bound that is touched", subjects_, members_, 11, false, draw_touching);
    return counted;
  }
  const battery::Tally& inside() const {
    static const battery::Tally counted =
        run<Flow>(name_ + ", a tolerance, inside", subjects_, members_, 12, false, draw_inside);
    return counted;
  }
  /// By schemes that ask the force at a step's end.
  const battery::Tally& fixed_steps() const {
    static const battery::Tally counted = by_fixed_steps(true);
    return counted;
  }
  /// By those that don't: the next step finds the state beyond the bound.
  const battery::Tally& blind_steps() const {
    static const battery::Tally counted = by_fixed_steps(false);
    return counted;
  }

 private:
  std::string name_;
  std::vector<Subject<Flow>> subjects_;
  int members_;

  [[nodiscard]] battery::Tally by_fixed_steps(bool asks_end) const {
    std::vector<Subject<Flow>> those = subjects_;
    std::erase_if(those, [&](const Subject<Flow>& subject) { return subject.asks_end != asks_end; });
    return run<Flow>(
        name_ + (asks_end ? ", fixed steps" : ", fixed steps, the end not asked"), those, members_, 13, true,
        [](truth::Random& random) { return random.chance(0.6) ? draw_touching(random) : draw_inside(random); });
  }
};

}  // namespace force_bounds
