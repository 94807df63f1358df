#pragma once

// States inside of steps against those at their ends: what all halves of accuracy/tolerance_samples need.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "support/catch.hpp"

namespace samples {

using namespace phistep;
template <class T>
using Two = Eigen::Matrix<T, 2, 1>;

/// Two components each: first a rotation, Van der Pol's oscillator (μ = 1), Prothero-Robinson with λ and λ/2; then motions,
/// two pendulums and an orbit of e = 0.3.
enum class Problem { rotation, van_der_pol, robinson_1e2, robinson_1e4, robinson_1e6, pendulums, kepler };
inline constexpr const char* names[] = {
    "rotation",  "Van der Pol", "Prothero-Robinson, 1e2", "Prothero-Robinson, 1e4", "Prothero-Robinson, 1e6",
    "pendulums", "Kepler"};
inline constexpr auto smooth = {Problem::rotation, Problem::van_der_pol};
inline constexpr auto stiff = {Problem::robinson_1e2, Problem::robinson_1e4, Problem::robinson_1e6};
inline constexpr auto motions = {Problem::pendulums, Problem::kepler};
[[nodiscard]] inline bool is_robinson(Problem p) { return p >= Problem::robinson_1e2 && p <= Problem::robinson_1e6; }
[[nodiscard]] inline double end_of(Problem p) { return p == Problem::kepler ? 6.283185307179586 : 10; }

/// y' = f(y, t)
template <class T>
struct Flow {
  Problem problem;
  Two<T> operator()(const Two<T>& y, T t) const {
    using std::cos, std::sin;
    if (problem == Problem::rotation) return {y[1], -y[0]};
    if (problem == Problem::van_der_pol) return {y[1], (1 - y[0] * y[0]) * y[1] - y[0]};
    const T lambda = problem == Problem::robinson_1e2 ? T(-1e2) : problem == Problem::robinson_1e4 ? T(-1e4) : T(-1e6);
    return {lambda * (y[0] - cos(t)) - sin(t), lambda / 2 * (y[1] - sin(2 * t)) + 2 * cos(2 * t)};
  }
};
/// r'' = f(r)
template <class T>
struct Pull {
  Problem problem;
  Two<T> operator()(const Two<T>& r) const {
    if (problem == Problem::pendulums) return {-std::sin(r[0]), -2 * std::sin(r[1])};
    const T square = r.squaredNorm();
    return -r / (square * std::sqrt(square));
  }
};

/// The solution at any time: by its formula, or by cubics between steps so small (of Kutta's method, in long double) that
/// both leave 1e-16.
class Solution {
 public:
  using Four = Eigen::Matrix<long double, 4, 1>;

  explicit Solution(Problem problem) : problem_{problem} {
    if (is_robinson(problem)) return;
    Four x = start();
    for (int n = 0; n <= static_cast<int>(end_of(problem) / static_cast<double>(h)) + 2; ++n) {
      const Four k1 = rate(x), k2 = rate(x + h / 2 * k1), k3 = rate(x + h / 2 * k2), k4 = rate(x + h * k3);
      value_.push_back(x);
      slope_.push_back(k1);
      for (const int block : {0, 1})
        scale_[block] = std::max(scale_[block], x.segment<2>(2 * block).cwiseAbs().maxCoeff());
      x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
  }
  [[nodiscard]] Four start() const {
    switch (problem_) {
      case Problem::rotation:
        return {1, 0.25L, 0, 0};
      case Problem::van_der_pol:
        return {2, 0, 0, 0};
      case Problem::pendulums:
        return {1.5L, 0.5L, 0, 1};
      case Problem::kepler:
        return {0.7L, 0, 0, std::sqrt(1.3L / 0.7L)};
      default:
        return {1, 0, 0, 0};
    }
  }
  /// Each block's largest error in units of its largest value.
  template <class S>
  [[nodiscard]] double error(long double t, const S& y) const {
    const Four exact = at(t);
    const auto off = [&](const auto& block, int k) {
      const auto difference = block.template cast<long double>() - exact.segment<2>(2 * k);
      return static_cast<double>(difference.cwiseAbs().maxCoeff() / scale_[k]);
    };
    if constexpr (EigenDense<S>) return off(y, 0);
    else return std::max(off(y.r, 0), off(y.v, 1));
  }

 private:
  static constexpr long double h = 5e-4L;
  [[nodiscard]] Four rate(const Four& x) const {
    Four out = Four::Zero();
    const Two<long double> first = x.head<2>();
    if (problem_ >= Problem::pendulums) out << x.tail<2>(), Pull<long double>{problem_}(first);
    else out.head<2>() = Flow<long double>{problem_}(first, 0);
    return out;
  }
  [[nodiscard]] Four at(long double t) const {
    if (is_robinson(problem_)) return {std::cos(t), std::sin(2 * t), 0, 0};
    const auto n = std::min(static_cast<std::size_t>(t / h), value_.size() - 2);
    const long double x = t / h - static_cast<long double>(n), z = 1 - x;
    return value_[n] + x * x * (3 - 2 * x) * (value_[n + 1] - value_[n]) +
           h * x * z * (z * slope_[n] - x * slope_[n + 1]);
  }

  Problem problem_;
  std::vector<Four> value_, slope_;
  long double scale_[2] = {is_robinson(problem_) ? 1.0L : 0.0L, 0};
};
[[nodiscard]] inline const Solution& solution(Problem p) {
  static const std::vector<Solution> all = [] {
    std::vector<Solution> made;
    for (int k = 0; k <= static_cast<int>(Problem::kepler); ++k) made.emplace_back(static_cast<Problem>(k));
    return made;
  }();
  return all[static_cast<std::size_t>(p)];
}
/// A hundred times each, evenly spaced and on a logarithmic scale.
[[nodiscard]] inline std::vector<double> times(double end) {
  std::vector<double> all;
  for (int k = 1; k < 100; ++k) {
    all.push_back(end * k / 100);
    all.push_back(end * std::pow(10, -6 * (1 - k / 100.0)));
  }
  return all;
}

/// Largest errors of a run, at the ends of its steps and inside them.
struct Errors {
  std::string trouble;
  double ends = 0, inside = 0;
  bool same = false;  ///< the bits and the number of steps of a run that nobody looks into
};
template <class S>
[[nodiscard]] Errors errors(Problem problem, double rtol, const S& start, auto&& make) {
  using T = ScalarOf<S>;
  const T end = static_cast<T>(end_of(problem));
  const tolerance wanted{.rtol = rtol, .atol = rtol, .max_steps = 1'000'000};
  const Solution& exact = solution(problem);
  Errors found;
  S y = start;
  auto stepper = make(y);
  const auto see = [&](const auto& step) { found.ends = std::max(found.ends, exact.error(step.t1(), step.end())); };
  const RunReport report = integrate(stepper, y, {T(0), end}, wanted, see, sampled(times(end), [&](T t, const S& now) {
                                       found.inside = std::max(found.inside, exact.error(t, now));
                                     }));
  if (!report) found.trouble = report.message();
  S alone = start;
  auto other = make(alone);
  const RunReport unseen = integrate(other, alone, {T(0), end}, wanted, [](const auto&) {});
  found.same = equal_blocks<S>(y, alone) && unseen.statistics.steps == report.statistics.steps;
  return found;
}

/// A step to where somebody looks may be off by one tolerance, an interpolant by half of one where it is checked: in a norm
/// √n times smaller than the largest of n components, with weights rtol (1 + |y|). Here n = 4 and |y| = 1: √4 · 2 rtol.
/// Found: 3.4 (a step of Radau's, stiff), else 1.9.
inline constexpr double share = 4;
inline void check(const std::string& name, std::initializer_list<Problem> problems, int coarsest, int finest,
                  const std::function<Errors(Problem, double rtol)>& run) {
  for (const Problem problem : problems)
    for (int digits = coarsest; digits <= finest; ++digits) {
      const double rtol = std::pow(10.0, -digits);
      const auto [trouble, ends, inside, same] = run(problem, rtol);
      CAPTURE(name, names[static_cast<int>(problem)], rtol, ends, inside, trouble);
      CHECK(trouble.empty());
      CHECK(inside <= share * std::max(ends, rtol));
      CHECK(same);
    }
}
template <class T = double>
void check_flow(const std::string& name, auto scheme, std::initializer_list<Problem> problems, int coarsest,
                int finest) {
  check(name, problems, coarsest, finest, [&](Problem p, double rtol) {
    const Two<T> start = solution(p).start().head<2>().template cast<T>();
    return errors(p, rtol, start, [&](const Two<T>& y) { return PhiStepper{y, Flow<T>{p}, scheme}; });
  });
}
template <class T = double>
void check_motion(const std::string& name, auto scheme, int coarsest, int finest) {
  check(name, motions, coarsest, finest, [&](Problem p, double rtol) {
    const Solution::Four x = solution(p).start();
    const Motion<Two<T>> start{Two<T>(x.head<2>().template cast<T>()), Two<T>(x.tail<2>().template cast<T>())};
    return errors(p, rtol, start, [&](const Motion<Two<T>>& y) { return PhiStepper{y, Pull<T>{p}, scheme}; });
  });
}

}  // namespace samples
