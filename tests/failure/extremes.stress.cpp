// The stress list at full length: Δt·ω over sixteen decades for every scheme, encounters as near as 1e-8, scales as far as
// numbers go, and what denormal numbers cost. The quick part: stress_list.test.cpp, units.test.cpp.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "support/figures.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Pair = Eigen::Vector2d;

namespace {

const double inf = std::numeric_limits<double>::infinity();

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// ---- Δt·ω ------------------------------------------------------------------------------------------------------------

/// A slow oscillator, ω = 1, and beside it one of any ω.
struct Oscillators {
  double square;
  Pair operator()(const Pair& r) const { return {-r[0], -square * r[1]}; }
};
constexpr double dt = 1.0 / 64;

struct Swept {
  double slow = 0;     ///< largest change of the slow part by what goes on beside it
  double largest = 0;  ///< energy of the fast one over its first, stable or not
  double growth = 0;   ///< log of its amplitude's factor a step, over the second half of the steps
  Outcome outcome = Outcome::success;
  int steps = 0;
  bool finite = true;
};
/// n steps of Δt·ω = a.
Swept sweep(auto scheme, double a, int n) {
  const double omega = a / dt;
  Motion<Pair> y{Pair(1, 1), Pair(0, 0)}, alone = y;
  PhiStepper both{y, Oscillators{omega * omega}, scheme}, one{alone, Oscillators{1}, scheme};
  Swept all;
  // Energy in units of the fast oscillator's own start, v in units of ω r.
  const auto amplitude = [&] { return std::hypot(y.r[1], y.v[1] / omega); };
  double half_way = 1;
  for (int k = 0; k < n; ++k) {
    if (k == n / 2) half_way = amplitude();
    const double t = k * dt;
    const StepReport report = both.step(y, t, dt);
    all.finite = all.finite && y.r.allFinite() && y.v.allFinite();
    if (!report) {
      all.outcome = report.outcome();
      break;
    }
    ++all.steps;
    static_cast<void>(one.step(alone, t, dt));
    all.slow = std::max({all.slow, std::abs(y.r[0] - alone.r[0]), std::abs(y.v[0] - alone.v[0])});
    all.largest = std::max(all.largest, amplitude());
  }
  all.growth = (std::log(amplitude()) - std::log(half_way)) / std::max(1, all.steps - n / 2);
  return all;
}
std::vector<double> decades() {
  std::vector<double> all;
  for (int e = -8; e <= 8; ++e)
    for (const double lead : {1.0, 3.7}) all.push_back(lead * std::pow(10.0, e));
  return all;
}

/// The worst of all schemes, and whose it is.
struct Worst {
  double value = 0;
  std::string whose = "all";
  void see(double x, const std::string& name) {
    if (x > value || std::isnan(x)) value = x, whose = name;
  }
};
struct SweptAll {
  Worst failures, largest, slow;
};

void stable(SweptAll& all, const std::string& name, auto scheme) {
  int failures = 0;
  for (const double a : decades()) {
    const Swept s = sweep(scheme, a, 2000);
    all.slow.see(s.slow, name), all.largest.see(s.largest, name);
    failures += s.outcome == Outcome::success && s.finite ? 0 : 1;
  }
  all.failures.see(failures, name);
}
/// Up to dt*omega = calm the amplitude stays; from `beyond` on it grows until no number holds it.
void conditional(SweptAll& all, const std::string& name, auto scheme, double calm, double beyond) {
  int wrong = 0;
  for (const double a : decades()) {
    const Swept s = sweep(scheme, a, 2000);
    wrong += s.finite ? 0 : 1;
    if (a <= calm) {
      wrong += s.outcome == Outcome::success ? 0 : 1;
      all.slow.see(s.slow, name), all.largest.see(s.largest, name);
    } else if (a >= beyond) {
      wrong += s.outcome == Outcome::non_finite_state || s.outcome == Outcome::non_finite_force ? 0 : 1;
    }
  }
  all.failures.see(wrong, name);
}

}  // namespace

TEST_CASE("dt omega from 1e-8 to 1e8: schemes that are stable for all") {
  SweptAll all;
  // Amplitudes in the energy norm: what a scheme's own matrix does to it. φ = ½ and the midpoint rule keep it.
  stable(all, "trapezoidal", trapezoidal);
  stable(all, "midpoint", midpoint);
  stable(all, "backward Euler", backward_euler);
  stable(all, "phi(0.7)", phi(0.7));
  stable(all, "TR-BDF2", tr_bdf2);
  figures::progress("phi-steps done");
  stable(all, "Rodas4", rodas4);
  stable(all, "Rodas5P", rodas5p);
  stable(all, "Radau, 3 stages", radau);
  figures::at_most(0, all.failures.value, "dt*omega 1e-8 ... 3.7e8, stable schemes: every step succeeds",
                   "8 schemes, worst: " + all.failures.whose);
  figures::at_most(1 + 1e-9, all.largest.value, "dt*omega 1e-8 ... 3.7e8, stable schemes: bounded",
                   "largest amplitude / first: " + all.largest.whose);
  figures::at_most(1e-12, all.slow.value, "dt*omega 1e-8 ... 3.7e8, stable schemes: the slow part's digits",
                   "change by the fast part: " + all.slow.whose);
}

TEST_CASE("dt omega from 1e-8 to 1e8: schemes with a limit") {
  SweptAll all;
  conditional(all, "velocity Verlet", velocity_verlet, 1, 2.1);
  conditional(all, "symplectic Euler", symplectic_euler, 1, 2.1);
  conditional(all, "SRKN6b", srkn6b, 1, 30);
  conditional(all, "SRKN11b", srkn11b, 1, 30);
  conditional(all, "RKN 8(6)", rkn86, 1, 30);
  conditional(all, "RKN 12(10)", rkn1210, 1, 30);
  conditional(all, "tsit5", tsit5, 1, 30);
  conditional(all, "dop853", dop853, 1, 30);
  figures::at_most(0, all.failures.value, "dt*omega: calm below the limit, an outcome beyond it",
                   "8 explicit schemes, worst: " + all.failures.whose);
  figures::at_most(3, all.largest.value, "dt*omega below the limit: bounded",
                   "largest amplitude / first: " + all.largest.whose);
  figures::at_most(1e-12, all.slow.value, "dt*omega below the limit: the slow part's digits",
                   "change by the fast part: " + all.slow.whose);
  // Velocity Verlet's growth is known: ρ = a²/2 − 1 + a√(a²/4 − 1).
  double off = 0;
  for (const double a : {2.5, 3.7, 10.0, 1e3}) {
    const double rho = a * a / 2 - 1 + a * std::sqrt(a * a / 4 - 1);
    const int n = static_cast<int>(600 / std::log(rho));
    const Swept s = sweep(velocity_verlet, a, n);
    off = std::max(off, std::abs(s.growth / std::log(rho) - 1));
  }
  figures::at_most(1e-9, off, "an unstable step grows as theory says", "velocity Verlet, log growth, relative");
  // Forward Euler: the amplitude grows by √(1 + a²) at every a.
  off = 0;
  for (const double a : {1e-3, 0.1, 1.0, 10.0, 1e4}) {
    const int n = static_cast<int>(std::min(1e5, 300 / std::log1p(a * a)));
    const Swept s = sweep(forward_euler, a, n);
    off = std::max(off, std::abs(s.growth / (0.5 * std::log1p(a * a)) - 1));
  }
  figures::at_most(1e-9, off, "an unstable step grows as theory says", "forward Euler, log growth, relative");
  const Swept end = sweep(forward_euler, 10, 2000);
  figures::at_most(0, end.outcome == Outcome::non_finite_state || end.outcome == Outcome::non_finite_force ? 0 : 1,
                   "what grows without end ends in an outcome", "forward Euler, a = 10");
}

// ---- close encounters ------------------------------------------------------------------------------------------------

namespace {

struct Attraction {
  Pair operator()(const Pair& r) const {
    const double d = r.stableNorm();
    return -r / d / d / d;
  }
};
double energy(const Motion<Pair>& y) { return y.v.squaredNorm() / 2 - 1 / y.r.norm(); }

void encounters(const std::string& name, auto scheme, double loosest) {
  double by_tolerance = 0, longest = 0, off = 0, largest_r = 0;
  int failures = 0, tries = 0;
  for (const double q : {1e-2, 1e-4, 1e-6, 1e-8})
    for (const double rtol : {1e-6, 1e-8, 1e-10}) {
      if (rtol > loosest) continue;
      Motion<Pair> y{Pair(2 - q, 0), Pair(0, std::sqrt(q / (2 - q)))};
      PhiStepper stepper{y, Attraction{}, scheme};
      const RunReport report =
          integrate(stepper, y, {0, 2 * std::numbers::pi}, tolerance{.rtol = rtol, .max_steps = 1000000});
      ++tries;
      failures += report ? 0 : 1;
      if (!report) continue;
      by_tolerance = std::max(by_tolerance, std::abs(energy(y) + 0.5) * q / rtol);
      if (q == 1e-8) longest = std::max(longest, report.smallest_dt);
    }
  // Head-on, a little beside, and at a centre where the clock is finest.
  for (const double beside : {0.0, 1e-12, 1e-8}) {
    Motion<Pair> y{Pair(-1, beside), Pair(1, 0)};
    PhiStepper stepper{y, Attraction{}, scheme};
    const RunReport report = integrate(stepper, y, {0, 2}, tolerance{.rtol = 1e-6, .max_steps = 1000000});
    ++tries;
    failures += report.outcome == Outcome::step_too_small && y.r.allFinite() && y.v.allFinite() ? 0 : 1;
    off = std::max(off, std::abs(report.t - (std::numbers::pi / 2 - 1)));
    largest_r = std::max(largest_r, y.r.norm());
  }
  figures::at_most(0, failures, "encounters: through, or step_too_small where there is no through",
                   name + ", of " + std::to_string(tries));
  figures::at_most(10, by_tolerance, "encounters to 1e-8: energy to 10 rtol of what was exchanged",
                   name + ", error / (rtol/q)");
  CHECK(longest <= 1e-11);  // dt shrinks by itself
  CHECK(off <= 1e-4);       // head-on the run ends at the collision
  figures::at_most(1e-9, largest_r, "head-on: the run ends at the collision", name + ", distance there");
}

}  // namespace

TEST_CASE("close encounters down to 1e-8, and head-on") {
  // Below rtol = κu with κ = 1/q nothing is promised; above, of what order the scheme is decides how long it takes.
  // An error of rtol/q in an energy of ½ may leave an orbit of the size of q, with too many turns to follow: where the promised
  // error is as large, at rtol = 1e-6, schemes are left out that came to that.
  encounters("RKN 8(6)", rkn86, 1e-8);
  encounters("RKN 12(10)", rkn1210, 1e-6);
  encounters("tsit5", tsit5, 1e-6);
  encounters("dop853", dop853, 1e-8);
  encounters("Radau", radau, 1e-6);
}

// ---- scales ----------------------------------------------------------------------------------------------------------

TEST_CASE("a problem of any size: y' = -y²/s from y = s, s = 1e-300 ... 1e300") {
  const auto run = [](const std::string& name, auto scheme, double rtol) {
    double worst = 0, unlike = 0, first = 0;
    int wrong = 0;
    for (const double s :
         {1.0, 1e-300, 1e-250, 1e-200, 1e-170, 1e-155, 1e-100, 1e100, 1e155, 1e170, 1e200, 1e250, 1e300}) {
      Vec y = Vec::Constant(2, s);
      PhiStepper stepper{y, std::function<Vec(const Vec&)>{[s](const Vec& x) -> Vec { return -x.cwiseProduct(x / s); }},
                         scheme};
      const RunReport report = integrate(stepper, y, {0, 3}, tolerance{.rtol = rtol});
      wrong += report ? 0 : 1;
      worst = std::max(worst, std::abs(y[0] / s * 4 - 1));
      if (s == 1) first = static_cast<double>(report.statistics.steps);
      unlike = std::max(unlike, std::abs(static_cast<double>(report.statistics.steps) - first));
    }
    CHECK(wrong == 0);
    CHECK(unlike <= 1);  // steps
    figures::at_most(100 * rtol, worst, "values from 1e-300 to 1e300: the same accuracy", name + ", largest error");
  };
  run("trapezoidal", trapezoidal, 1e-5);
  run("Rodas4", rodas4, 1e-5);
  run("Radau", radau, 1e-7);
  run("tsit5", tsit5, 1e-5);
  run("dop853", dop853, 1e-7);
}

// ---- odd but legal ---------------------------------------------------------------------------------------------------

namespace {

struct Odd {
  std::string what;
  std::function<Vec(const Vec&)> force;
  Vec y;
  double t1;
  tolerance control;
  double expected;                  ///< of y_0, within 1 %, where the run succeeds
  std::vector<Outcome> else_any{};  ///< outcomes that are right as well; with a success first: it may not fail
};

void odd_inputs(const std::string& name, auto scheme) {
  const auto none = [](const Vec& x) -> Vec { return Vec::Zero(x.size()); };
  const auto constant = [](const Vec& x) -> Vec { return Vec::Constant(x.size(), 3.0); };
  const auto decay = [](const Vec& x) -> Vec { return -x; };
  const auto grow = [](const Vec& x) -> Vec { return x; };
  const auto square = [](const Vec& x) -> Vec { return x.cwiseProduct(x); };
  const auto root = [](const Vec& x) -> Vec { return x.array().sqrt().matrix(); };
  const auto sign = [](const Vec& x) -> Vec { return -x.array().sign().matrix(); };
  const Vec ones = Vec::Ones(2), zeros = Vec::Zero(2);
  const double e = std::exp(-1.0), most = std::numeric_limits<double>::max();
  using enum Outcome;
  const std::vector<Outcome> any{non_finite_state, non_finite_force,    non_finite_jacobian, newton_diverged,
                                 newton_stalled,   step_too_small,      too_many_steps,      error_too_large,
                                 singular_matrix,  linear_solver_failed};
  const std::vector<Odd> all{
      {"no force", none, ones, 1, {}, 1},
      {"no force, y = 0, atol = 0", none, zeros, 1, {.atol = 0.0}, 0},
      {"y = 0, atol = 0", decay, zeros, 1, {.atol = 0.0}, 0},
      {"one component 0, atol = 0", decay, Vec(Pair(1, 0)), 1, {.atol = 0.0}, e},
      {"a constant force from 0, atol = 0", constant, zeros, 1, {.atol = 0.0}, 3},
      {"backward", decay, ones, -1, {}, 1 / e},
      {"first step 1e300", decay, ones, 1, {.first_step = 1e300}, e},
      {"nobody", decay, Vec(0), 1, {}, 0},
      {"one number", decay, Vec::Ones(1), 1, {}, e},
      {"t1 = t0", decay, ones, 0, {}, 1},
      {"one try", decay, ones, 1, {.max_steps = 1}, e, {too_many_steps}},
      {"no try", decay, ones, 1, {.max_steps = 0}, e, {too_many_steps}},
      {"no end", decay, ones, inf, {}, 0, {invalid_step}},
      {"1e300 beside 1e-300, atol = 0", decay, Vec(Pair(1e300, 1e-300)), 1, {.atol = 0.0}, 1e300 * e},
      {"the largest number", decay, Vec::Constant(2, most), 1, {}, most * e, any},
      {"growth beyond all numbers", grow, ones, 1000, {.rtol = 1e-3}, 0, any},
      {"a pole", square, ones, 2, {.max_steps = 200'000}, 0, any},
      {"a root's edge", root, zeros, 1, {}, 0, any},
      {"a force that changes its sign for ever",
       sign,
       ones,
       2,
       {.rtol = 1e-3, .atol = 1e-3, .max_steps = 20'000},
       0,
       any},
      {"rtol near rounding", decay, ones, 1e-3, {.rtol = 1e-13}, std::exp(-1e-3), {invalid_tolerance}},
      {"rtol of a half", decay, ones, 0.1, {.rtol = 0.5}, std::exp(-0.1)},
  };
  int wrong = 0;
  for (const Odd& odd : all) {
    CAPTURE(name, odd.what);
    Vec y = odd.y;
    PhiStepper stepper{y, odd.force, scheme};
    const RunReport report = integrate(stepper, y, {0, odd.t1}, odd.control);
    const double got = y.size() > 0 ? y[0] : 0;
    // A success that could not be, or one that is not; a failure of a run that could, or of another kind.
    const bool impossible = odd.expected == 0 && !odd.else_any.empty() && odd.what != "a root's edge" &&
                            odd.what != "a force that changes its sign for ever";
    const double allowed = odd.what == "rtol of a half" ? 0.05 : odd.what.starts_with("a force that") ? 0.01 : 0;
    const bool right = report
                           ? !impossible && std::abs(got - odd.expected) <= 0.01 * std::abs(odd.expected) + allowed
                           : std::find(odd.else_any.begin(), odd.else_any.end(), report.outcome) != odd.else_any.end();
    CAPTURE(got, odd.expected, report.message());
    CHECK((right && y.allFinite()));
    wrong += right && y.allFinite() ? 0 : 1;
  }
  figures::at_most(0, wrong, "odd but legal input: the answer, or an outcome that says why",
                   name + ", of " + std::to_string(all.size()));
}

}  // namespace

TEST_CASE("odd but legal input: the answer, or an outcome that says why") {
  odd_inputs("trapezoidal", trapezoidal);
  odd_inputs("Rodas4", rodas4);
  odd_inputs("Radau", radau);
  odd_inputs("tsit5", tsit5);
  odd_inputs("dop853", dop853);
}

// ---- denormal numbers ------------------------------------------------------------------------------------------------

TEST_CASE("what denormal numbers cost") {
  const auto time = [](double speed) {
    constexpr int n = 20000;
    Motion<Vec> y{Vec::Constant(n, 1.0), Vec::Constant(n, speed)};
    PhiStepper stepper{y, [](const Vec& r) -> Vec { return Vec::Zero(r.size()); }, velocity_verlet};
    double best = inf;
    for (int round = 0; round < 8; ++round) {
      const double start = thread_seconds();
      for (int k = 0; k < 50; ++k) REQUIRE(stepper.step(y, k, 1e-3));
      best = std::min(best, thread_seconds() - start);
    }
    REQUIRE(y.v == Vec::Constant(n, speed));
    return best;
  };
  const double normal = time(1e-3);
  figures::told(time(1e-310) / normal, "denormal velocities: cost of a Verlet step", "times that of normal ones");
  figures::told(time(0) / normal, "denormal velocities: cost of a Verlet step", "… beside that of zeros");
}
