/// @file
/// Before the first step: what Δt and φ will do to this force, these masses and this state.
///
///     phistep::PhiStepper stepper{sheet, springs, phistep::velocity_verlet, phistep::mass(m)};
///     const auto report = phistep::preflight(stepper, sheet, 1e-3, {.period = 0.5});
///     if (!report) std::cout << report;      // report.verdict, report.stable_dt, report.terms[k].frequency, …
///
/// The force is linearized at the state, term by term (its own Jacobian, or differences), and its rates are bounded from
/// above: exactly for up to 200 unknowns (r and v counted), by weighted Gershgorin discs beyond (spectral_bound.hpp). So is
/// Δt: stable by guarantee, for the linearized problem; where the stiffness changes, ask again. Nothing is stepped, no
/// count changes, nothing is thrown.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <complex>
#include <exception>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/force/at.hpp"
#include "phistep/force/linear.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/run/stepper/phi_stepper.hpp"
#include "phistep/schemes/generalized_alpha.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/study/assess.hpp"
#include "phistep/study/checks/tangent.hpp"
#include "phistep/study/stability/method.hpp"
#include "phistep/study/stability/report.hpp"
#include "phistep/study/stability/spectrum.hpp"
#include "phistep/study/stability/stable_step.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a user writes for it.
template <class F, class D, Form form>
[[nodiscard]] std::string scheme_name(const PhiScheme<F, D, form>& scheme) {
  const double f = scheme.force.template value<double>(), d = scheme.drift.template value<double>();
  if (const std::string name = scheme.name(); !name.starts_with("phi") && !name.starts_with("a pair")) return name;
  return (form == Form::stage ? "phi_stage(" : "phi(") + number_text(f, 3) + (f == d ? "" : ", " + number_text(d, 3)) +
         ')';
}
[[nodiscard]] inline std::string scheme_name(const GeneralizedAlpha& scheme) {
  return "generalized_alpha(" + number_text(scheme.rho, 3) + ')';
}
[[nodiscard]] inline std::string scheme_name(const NewmarkAlpha& scheme) {
  const AlphaWeights& w = scheme.given;
  if (w.alpha_f != 0) return "hht(" + number_text(-w.alpha_f, 3) + ')';
  if (w.alpha_m != 0) return "bossak(" + number_text(w.alpha_m, 3) + ')';
  return "newmark(" + number_text(w.beta, 3) + ", " + number_text(w.gamma, 3) + ')';
}
/// What a scheme calls itself.
template <class Scheme>
[[nodiscard]] std::string scheme_name(const Scheme& scheme) {
  if constexpr (requires { scheme.name(); }) return scheme.name();
  else return "this scheme";
}

/// The Method of a scheme that no formula of method.hpp describes, by one step: of y' = z y, z = a + ib as a 2×2 matrix, or of
/// an oscillator if the scheme takes motions alone. NaN where such a step fails.
template <class Scheme>
[[nodiscard]] Method method_of(const Scheme& scheme) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Method method;
  if constexpr (Scheme::facts.motion_only) {
    method.kind = Method::Kind::motion;
    method.swing = [scheme, nan](double a) {
      using One = Eigen::Matrix<double, 1, 1>;
      Eigen::Matrix2d G;
      for (int j = 0; j < 2; ++j) {
        Motion<One> y{One(j == 0 ? 1.0 : 0.0), One(j == 0 ? 0.0 : 1.0)};
        PhiStepper stepper{y, linear(One(-a * a)), scheme};
        if (!stepper.step(y, 0, 1)) return std::complex{nan, nan};
        G.col(j) << y.r, y.v;
      }
      return larger_eigenvalue(G.trace(), G.determinant());
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

/// Generalized-α and Newmark's family: the largest roots of what (1) to (3) of schemes/generalized_alpha.hpp make of y' = zy (of a
/// motion, v' = zv) and of r'' = −a²r, Δt = 1,
///
///     (λ−1) ((1−α_m)λ + α_m) = z (γλ + 1−γ) ((1−α_f)λ + α_f)
///     (λ−1)² ((1−α_m)λ + α_m) = −a² ((1−α_f)λ + α_f) (βλ² + (½+γ−2β)λ + ½+β−γ)
template <HasAlphaWeights Scheme>
[[nodiscard]] Method method_of(const Scheme& scheme, bool is_motion) {
  const AlphaWeights w = scheme.weights(is_motion);
  Method method;
  method.a_stable = 2 * w.beta >= w.gamma - 1e-12;
  method.kind = method.a_stable ? Method::Kind::rational : Method::Kind::motion;
  method.R = [w](std::complex<double> z) {
    const double m = w.alpha_m, f = w.alpha_f, g = w.gamma;
    const std::complex<double> a = 1 - m - z * (g * (1 - f)), b = 2 * m - 1 - z * ((1 - g) * (1 - f) + g * f),
                               c = -m - z * ((1 - g) * f), root = std::sqrt(b * b - 4.0 * a * c);
    return std::norm(root - b) > std::norm(root + b) ? (root - b) / (2.0 * a) : -(root + b) / (2.0 * a);
  };
  if (!is_motion) return method;
  method.bears_damping = true;
  method.swing = [w](double a) {
    const double m = w.alpha_m, f = w.alpha_f, q = a * a, p1 = 0.5 + w.gamma - 2 * w.beta, p0 = 0.5 + w.beta - w.gamma;
    const double c3 = 1 - m + q * (1 - f) * w.beta, c2 = 3 * m - 2 + q * ((1 - f) * p1 + f * w.beta),
                 c1 = 1 - 3 * m + q * ((1 - f) * p0 + f * p1), c0 = m + q * f * p0;
    Eigen::MatrixXd companion{{-c2 / c3, -c1 / c3, -c0 / c3}, {1, 0, 0}, {0, 1, 0}};
    std::complex<double> largest = 0;
    for (const auto lambda : eigenvalues_of(companion))
      if (std::abs(lambda) > std::abs(largest)) largest = lambda;
    return std::complex<double>{largest.real(), std::abs(largest.imag())};
  };
  return method;
}

/// Slow terms: what an outer step does to an oscillation of which each term has a part in proportion to its stiffness.
template <class = void>
[[nodiscard]] Method describe_slow(const LinearizedProblem& problem, PreflightReport& report) {
  const auto stiffness = [&](const Tangent& tangent) {
    return spectrum_of(tangent, problem.masses, problem.block, problem.tolerance).stiffness;
  };
  const std::vector<int> every = problem.every();
  const double fast = stiffness(problem.rest);
  std::vector<double> slow;
  double sum = fast;
  for (const LinearizedProblem::Slow& one : problem.slow) sum += slow.emplace_back(stiffness(one.tangent));
  report.inner_steps = *std::max_element(every.begin(), every.end());
  const bool one_level = std::all_of(every.begin(), every.end(), [&](int k) { return k == report.inner_steps; });
  if (one_level && report.dt > 0 && problem.whole.known)
    report.most_k = most_inner_steps(fast, sum - fast, report.dt / report.inner_steps);
  Method method;
  method.kind = Method::Kind::motion;
  method.swing = [=, inner = problem.inner, begin = problem.begin_weight()](double a) {
    const auto kick = [](double gamma, double square) { return Eigen::Matrix2d{{1, 0}, {-gamma * square, 1}}; };
    const auto part = [&](double of) { return sum > 0 ? a * a * of / sum : a * a; };
    const auto G = outer_step_matrix<Eigen::Matrix2d>(
        1, every, begin,
        [&](double h) -> Eigen::Matrix2d {
          return kick((1 - begin) * h, part(fast)) * Eigen::Matrix2d{{1, h}, {0, 1}} * kick(begin * h, part(fast));
        },
        [&](std::size_t j, double gamma) { return kick(gamma, part(slow[j])); });
    return larger_eigenvalue(G.trace(), G.determinant());
  };
  return method;
}

/// How long impacts last and how deep they go, by the terms with a member contact_time(y) or impacts(y).
template <class F, class View>
void ask_of_impacts(F& force, const View& y, double& shortest, PreflightReport& report) {
  const bool is_given = shortest > 0;
  for_each_summand(force, [&](auto& term) {
    if constexpr (requires { term.contact_time(y); })
      if (const auto one = static_cast<double>(term.contact_time(y));
          !is_given && one > 0 && (shortest == 0 || one < shortest))
        shortest = one;
    if constexpr (requires { term.impacts(y); }) {
      const auto impacts = term.impacts(y);
      report.penetration = std::max(report.penetration, impacts.deepest);
      report.is_lossless = report.is_lossless || impacts.lossless;
    }
  });
}

/// What Δt and the stepper's scheme will do to this force, these masses and this state.
/// @param dt  [time] the step you have in mind
template <State S, class F, class Scheme, class MassSpec, ImplicitSolver Solver>
[[nodiscard]] PreflightReport preflight(PhiStepper<S, F, Scheme, MassSpec, Solver>& stepper, const S& state, double dt,
                                        const PreflightOptions& options = {}) {
  using Scalar = ScalarOf<S>;
  PreflightReport report;
  report.dt = dt;
  const bool valid = dt > 0 && std::isfinite(dt);
  if (!valid) report.verdict = Verdict::invalid;
  try {
    PlainState<S> y;
    copy_blocks<S>(y, state);
    if (first_non_finite(Blocks<S>::all(y))) {
      report.finding = "The state is not finite: no step can start from it.";
      report.whole.finite = false;
      if (valid) report.verdict = Verdict::unknown;
      return report;
    }
    auto& force = stepper.force_to_look_at();
    using Whole = std::remove_cvref_t<decltype(force)>;
    const auto masses = bind_masses<S>(StepperInternals::mass(stepper), y);
    if (algebraic_component(masses))
      throw std::invalid_argument("M is singular: preflight judges no differential-algebraic equations.");
    using Rhs = RightHandSide<S, std::reference_wrapper<Whole>, std::remove_cvref_t<decltype(masses)>>;
    LinearizedProblem problem;
    problem.masses = preflight_masses<S>(y, masses);
    problem.block = particle_rows<S, typename Rhs::Traits>(y);
    problem.tolerance = 64 * std::sqrt(static_cast<double>(std::numeric_limits<Scalar>::epsilon()));
    const auto t = static_cast<Scalar>(options.t), step = static_cast<Scalar>(valid ? dt : 0);
    const auto linearize = [&](auto& part, const auto& memory) {
      return tangent_of<S>(part, t, step, y, masses, memory, problem.masses);
    };
    if constexpr (is_sum<Whole>) {
      const auto add = [](Tangent& sum, const Tangent& part) {
        sum = {sum.K + part.K, sum.C + part.C, sum.known && part.known, sum.finite && part.finite};
      };
      problem.whole = problem.rest = problem.kicks = zero_tangent<S>(y);
      double stiffest = 0;
      for_each_term(force, stepper.memory(), [&](auto k, auto& part, const auto& memory) {
        constexpr bool kick = is_split<Whole, Scheme> && is_kick<std::tuple_element_t<k(), decltype(force.terms)>>;
        const Tangent tangent = linearize(part, memory);
        const Spectrum s = spectrum_of(tangent, problem.masses, problem.block, problem.tolerance);
        report.terms.push_back(term_report(tangent, s, problem.block));
        const auto& marked = std::get<k()>(force.terms);
        constexpr bool is_slow = is_seldom<std::remove_cvref_t<decltype(marked)>>;
        report.terms.back().is_kick = kick && !is_slow;
        if (s.radius > stiffest) report.stiffest = static_cast<int>(k()), stiffest = s.radius;
        add(problem.whole, tangent);
        if constexpr (is_slow) {
          report.terms.back().k = marked.k();
          problem.slow.push_back({tangent, marked.k()});
        } else {
          add(kick ? problem.kicks : problem.rest, tangent);
          problem.has_kicks = problem.has_kicks || kick;
        }
      });
    } else {
      problem.whole = problem.rest = linearize(force, stepper.memory());
    }
    PreflightOptions asked = options;
    ask_of_impacts(force, Blocks<S>::view(y, masses), asked.contact_time, report);
    const auto& scheme = StepperInternals::scheme(stepper);
    if constexpr (HasAlphaWeights<Scheme>) problem.inner = method_of(scheme, Blocks<S>::drifts);
    else problem.inner = method_of(scheme);
    const Method method = problem.slow.empty() ? problem.inner : describe_slow(problem, report);
    Assessment<>{problem, method, scheme_name(scheme), asked, report}.run();
  } catch (const std::exception& error) {
    report.verdict = valid ? Verdict::unknown : Verdict::invalid;
    report.finding = error.what();
  }
  return report;
}
/// For a stepper around a stepper: the report of the stepper inside.
template <class Stepper, State S>
  requires requires(Stepper& outer) { outer.stepper(); }
[[nodiscard]] PreflightReport preflight(Stepper& outer, const S& state, double dt,
                                        const PreflightOptions& options = {}) {
  return preflight(outer.stepper(), state, dt, options);
}

}}  // namespace phistep::PHISTEP_ABI
