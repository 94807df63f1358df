/// @file
/// A scheme that no formula of method.hpp describes, and an outer step with slow terms: what a step of theirs does to a mode.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <complex>
#include <limits>
#include <string>
#include <vector>

#include "phistep/base/state/motion.hpp"
#include "phistep/force/linear.hpp"
#include "phistep/run/stepper/phi_stepper.hpp"
#include "phistep/study/stability/method.hpp"
#include "phistep/study/stability/report.hpp"
#include "phistep/study/stability/slow_terms.hpp"
#include "phistep/study/stability/spectrum.hpp"
#include "phistep/study/stability/stable_step.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a user writes for it.
template <class F, class D, Form form>
[[nodiscard]] std::string scheme_name(const PhiScheme<F, D, form>& scheme) {
  const double f = scheme.force.template value<double>(), d = scheme.drift.template value<double>();
  if (const std::string name = scheme.name(); !name.starts_with("phi") && !name.starts_with("a pair")) return name;
  return (form == Form::stage ? "phi_stage(" : "phi(") + short_number(f) + (f == d ? "" : ", " + short_number(d)) + ')';
}
/// What a scheme calls itself.
template <class Scheme>
[[nodiscard]] std::string scheme_name(const Scheme& scheme) {
  if constexpr (requires { scheme.name(); }) return scheme.name();
  else return "this scheme";
}

/// One oscillator r'' = −a² r.
struct TestOscillator : ForceTerm {
  double a_squared;
  static constexpr bool uses_velocity = false, uses_time = false, is_affine = true;
  explicit TestOscillator(double a) : a_squared{a * a} {}
  void add(auto /*t*/, const auto& y, auto& out) const { out.force -= a_squared * y.r; }
  void add_jacobian(auto /*t*/, const auto& /*y*/, auto& sink) const { sink.position(0, 0, -a_squared); }
};
/// A scheme that no formula of method.hpp describes: as its own steps tell, of y' = z y, z = x + iy as a 2×2 matrix, or of an
/// oscillator where it takes motions alone. NaN where such a step fails.
template <class Scheme>
[[nodiscard]] Method method_of(const Scheme& scheme) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Method method;
  if constexpr (Scheme::facts.motion_only) {
    method.kind = Method::Kind::motion;
    method.step_of = [scheme, nan](double a) {
      using One = Eigen::Matrix<double, 1, 1>;
      Eigen::Matrix2d G;
      for (int j = 0; j < 2; ++j) {
        Motion<One> y{One(j == 0 ? 1.0 : 0.0), One(j == 0 ? 0.0 : 1.0)};
        PhiStepper stepper{y, TestOscillator{a}, scheme};
        if (stepper.step(y, 0, 1)) G.col(j) << y.r, y.v;
        else G.setConstant(nan);
      }
      return G;
    };
  } else {
    method.kind = Method::Kind::rational;
    method.a_stable = Scheme::facts.is_a_stable;
    method.R = [scheme](std::complex<double> z) -> std::complex<double> {
      Eigen::Matrix2d A;
      A << z.real(), -z.imag(), z.imag(), z.real();
      Eigen::Vector2d y{1, 0};
      PhiStepper stepper{y, linear(A), scheme};
      if (!stepper.step(y, 0, 1)) return {nan, nan};
      return {y[0], y[1]};
    };
  }
  return method;
}

/// With slow terms: what an outer step does to an oscillation of which each term has a part as large as its own stiffness.
template <class = void>
[[nodiscard]] Method describe_slow(const LinearisedProblem& problem, PreflightReport& report) {
  const auto stiffness = [&](const Tangent& tangent) {
    return spectrum_of(tangent, problem.masses, problem.block, problem.tolerance).stiffness;
  };
  const std::vector<int> every = problem.every();
  const double fast = stiffness(problem.rest);
  std::vector<double> slow;
  double sum = fast;
  for (const LinearisedProblem::Slow& one : problem.slow) sum += slow.emplace_back(stiffness(one.tangent));
  report.inner_steps = *std::max_element(every.begin(), every.end());
  const bool one_level = std::all_of(every.begin(), every.end(), [&](int k) { return k == report.inner_steps; });
  if (one_level && report.dt > 0 && problem.whole.known)
    report.most_k = most_inner_steps(fast, sum - fast, report.dt / report.inner_steps);
  Method method;
  method.kind = Method::Kind::motion;
  method.step_of = [=, inner = problem.inner, begin = problem.begin_weight()](double a) {
    const auto kick = [](double gamma, double square) { return Eigen::Matrix2d{{1, 0}, {-gamma * square, 1}}; };
    const auto part = [&](double of) { return sum > 0 ? a * a * of / sum : a * a; };
    return outer_step_matrix<Eigen::Matrix2d>(
        Eigen::Matrix2d::Identity(), 1, every, begin,
        [&](double h) -> Eigen::Matrix2d {
          return kick((1 - begin) * h, part(fast)) * Eigen::Matrix2d{{1, h}, {0, 1}} * kick(begin * h, part(fast));
        },
        [&](std::size_t j, double gamma) { return kick(gamma, part(slow[j])); });
  };
  return method;
}

}}  // namespace phistep::PHISTEP_ABI
