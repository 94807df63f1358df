/// @file
/// Whether a scheme, the library's or one's own, does what every scheme must:
///
///     const BatteryReport report = check_scheme(my_scheme);
///     if (!report) std::cout << report;
///
/// · The observed order log₂(e(Δt)/e(Δt/2)) is the one it names, p: between p − 0.4 and p + 0.9 (1.15 p from order 7 on: their
///   steps are long); inside of steps it is at least min(p, 4) − 0.5.
/// · A step whose force isn't finite fails and leaves every bit of the state; what follows has the bits of a twin that never failed.
/// · A step taken back by `checkpoint` and `restore` and done again ends where it did, to 1e-13: solves keep their matrix.
/// · In units 2^20 times as small a run at a fixed Δt has the same bits.
/// · Under a tolerance the error is at most 100 rtol, inside of steps, too.
///
/// The problems have solutions in closed form, without a singularity, 0 ≤ t ≤ 4:
///
///     y₀' = −e^t y₀²,             y₁' = y₁ cos t             y₀ = e^{−t},   y₁ = e^{sin t}                          (1)
///     r₀'' = −r₀ (2 r₀² − r₁),    r₁'' = 4 − 8 r₀²           r₀ = cos t,    r₁ = cos 2t                             (2)
///     r₀'' = e^t v₀²,             r₁'' = −2 r₁ − 2 v₁        r₀ = e^{−t},   r₁ = e^{−t} cos t                       (3)
///
/// (1) and (3) where the scheme takes first-order states, (2) always.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/run/control/fixed_step.hpp"
#include "phistep/run/errors/tolerance.hpp"
#include "phistep/run/observers/at_times.hpp"
#include "phistep/run/run.hpp"
#include "phistep/run/stepper/phi_stepper.hpp"
#include "phistep/study/battery/battery_report.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

namespace battery {
using Two = Eigen::Vector2d;

/// Problem (1) of the file's head, its numbers multiplied by `unit`; the force is NaN while *broken.
struct FirstOrder {
  static constexpr const char* name = "first order";
  using State = Two;
  double unit = 1;
  [[nodiscard]] State at(double t) const { return unit * Two{std::exp(-t), std::exp(std::sin(t))}; }
  [[nodiscard]] auto force(const bool* broken) const {
    return [unit = unit, broken](const Two& y, double t) -> Two {
      return *broken ? Two{Two::Constant(NAN)} : Two{-std::exp(t) * y[0] * (y[0] / unit), std::cos(t) * y[1]};
    };
  }
};
/// Problem (2).
struct Undamped {
  static constexpr const char* name = "motion";
  using State = Motion<Two>;
  double unit = 1;
  [[nodiscard]] State at(double t) const {
    return {unit * Two{std::cos(t), std::cos(2 * t)}, unit * Two{-std::sin(t), -2 * std::sin(2 * t)}};
  }
  [[nodiscard]] auto force(const bool* broken) const {
    return [unit = unit, broken](const Two& r) -> Two {
      const double x = r[0] / unit;
      return *broken ? Two{Two::Constant(NAN)} : unit * Two{-x * (2 * x * x - r[1] / unit), 4 - 8 * x * x};
    };
  }
};
/// Problem (3).
struct Damped {
  static constexpr const char* name = "damped motion";
  using State = Motion<Two>;
  double unit = 1;
  [[nodiscard]] State at(double t) const {
    const double e = std::exp(-t);
    return {unit * Two{e, e * std::cos(t)}, unit * Two{-e, -e * (std::cos(t) + std::sin(t))}};
  }
  [[nodiscard]] auto force(const bool* broken) const {
    return [unit = unit, broken](const Two& r, const Two& v, double t) -> Two {
      return *broken ? Two{Two::Constant(NAN)} : Two{std::exp(t) * v[0] * (v[0] / unit), -2 * r[1] - 2 * v[1]};
    };
  }
};

[[nodiscard]] inline double distance(const Two& a, const Two& b) { return (a - b).norm(); }
[[nodiscard]] inline double distance(const Motion<Two>& a, const Motion<Two>& b) {
  return std::hypot((a.r - b.r).norm(), (a.v - b.v).norm());
}

template <class Problem, class Scheme>
class SchemeBattery {
  using S = typename Problem::State;

 public:
  SchemeBattery(const Scheme& scheme, BatteryReport& report) : scheme_{scheme}, report_{report} {}
  void run() {
    order_ = stepper_of(Problem{}).order();
    check_orders();
    check_failure();
    check_restore();
    check_units();
    check_tolerance();
  }

 private:
  [[nodiscard]] auto stepper_of(const Problem& problem) const {
    return PhiStepper{problem.at(0), problem.force(&broken_), scheme_};
  }
  void check(bool holds, const char* text, auto... figures) {
    std::string line = Problem::name;
    line += ": ";  // g++ 12 warns of what a + b + c would copy
    report_.check(holds, line += text, figures...);
  }
  /// The largest errors at the ends of steps from t = 2 on, and inside of steps; NaN where the run fails.
  [[nodiscard]] std::array<double, 2> errors(auto control) {
    const Problem problem;
    auto stepper = stepper_of(problem);
    S y = problem.at(0);
    double at_ends = 0, inside = 0;
    const auto note = [&problem](double& largest, double t, const S& x) {
      const double error = distance(x, problem.at(t));
      largest = std::isnan(error) ? INFINITY : std::max(largest, error);  // std::max passes over a NaN
    };
    const bool done{integrate(
        stepper, y, {0.0, 4.0}, control, sampled({0.37, 2.16, 3.81}, [&](double t, const S& x) { note(inside, t, x); }),
        [&](double t, const S& x) { note(at_ends, t >= 2 ? t : 0, t >= 2 ? x : problem.at(0)); })};
    if (!done) return {NAN, NAN};
    return {at_ends, inside};
  }
  /// Errors below are rounding, or that of Jacobians by differences.
  static constexpr double rounding = Scheme::facts.is_explicit ? 1e-13 : 1e-11;
  /// The median of the last three slopes above rounding.
  [[nodiscard]] static double slope(const std::vector<double>& errors) {
    std::vector<double> slopes;
    for (std::size_t k = 1; k < errors.size() && !(errors[k] < rounding); ++k)
      slopes.push_back(std::log2(errors[k - 1] / errors[k]));
    if (slopes.empty()) return NAN;
    const auto last = slopes.end() - std::min<std::ptrdiff_t>(3, std::ssize(slopes));
    std::sort(last, slopes.end());
    return last[(slopes.end() - last) / 2];
  }
  void check_orders() {
    std::vector<double> ends, insides;
    for (int n = order_ > 6 ? 4 : 16; n <= 1024 && (ends.empty() || ends.back() >= rounding); n *= 2) {
      const auto [end, inside] = errors(fixed(4.0 / n));
      ends.push_back(end), insides.push_back(inside);
    }
    const double seen = slope(ends), within = slope(insides);
    check(seen > order_ - 0.4 && seen < std::max(order_ + 0.9, 1.15 * order_), "observed order %.2f, named %d", seen,
          order_);
    const double least = std::min(order_, 4) - 0.5;
    check(within > least || insides.back() < 1e-11, "observed order inside of steps %.2f, at least %.1f", within,
          least);
  }
  void check_failure() {
    auto one = stepper_of(Problem{}), twin = stepper_of(Problem{});
    S y = Problem{}.at(0), other = y;
    bool good = one.step(y, 0.0, 0.1) && twin.step(other, 0.0, 0.1);
    broken_ = true;
    one.reset(), twin.reset();
    good = !one.step(y, 0.1, 0.1) && good;
    check(good && equal_blocks<S>(y, other), "a step with a force of NaN fails and leaves every bit");
    broken_ = false;
    good = one.step(y, 0.1, 0.1) && twin.step(other, 0.1, 0.1);
    check(good && equal_blocks<S>(y, other), "after a failure a step has the bits of a twin's");
  }
  void check_restore() {
    auto stepper = stepper_of(Problem{});
    S y = Problem{}.at(0);
    bool good = true;
    for (int k = 0; k < 5; ++k) good = stepper.step(y, 0.02 * k, 0.02) && good;
    const auto kept = stepper.checkpoint();
    S again = y;
    good = stepper.step(y, 0.1, 0.02) && good;
    stepper.restore(kept);
    good = stepper.step(again, 0.1, 0.02) && good;
    check(good && distance(y, again) <= 1e-13, "a step taken back and done again ends %.1e apart", distance(y, again));
  }
  void check_units() {
    const Problem tiny{0x1p-20};
    auto one = stepper_of(Problem{}), other = stepper_of(tiny);
    S y = Problem{}.at(0), x = tiny.at(0);
    bool good = true;
    for (int k = 0; k < 5; ++k) good = one.step(y, 0.02 * k, 0.02) && other.step(x, 0.02 * k, 0.02) && good;
    for_each_block([](auto, auto& block) { block *= 0x1p20; }, Blocks<S>::all(x));
    check(good && equal_blocks<S>(x, y), "in units 2^20 times as small: %.1e apart", distance(x, y));
  }
  void check_tolerance() {
    const auto [end, inside] = errors(tolerance{.rtol = 1e-5, .atol = 1e-7});
    check(end <= 1e-3 && inside <= 1e-3, "under rtol = 1e-5 the error is %.1e, inside of steps %.1e", end, inside);
  }

  const Scheme& scheme_;
  BatteryReport& report_;
  int order_ = 0;
  bool broken_ = false;
};
}  // namespace battery

/// Whether a scheme does what every scheme must, on the problems (1) to (3): a line for each check; some milliseconds.
template <class Scheme>
[[nodiscard]] BatteryReport check_scheme(const Scheme& scheme) {
  BatteryReport report;
  if constexpr (!Scheme::facts.motion_only) {
    battery::SchemeBattery<battery::FirstOrder, Scheme>{scheme, report}.run();
    battery::SchemeBattery<battery::Damped, Scheme>{scheme, report}.run();
  }
  battery::SchemeBattery<battery::Undamped, Scheme>{scheme, report}.run();
  return report;
}

}}  // namespace phistep::PHISTEP_ABI
