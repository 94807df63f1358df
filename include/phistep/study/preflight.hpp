/// @file
/// Before the first step: what Δt and φ will do to this force, these masses and this state.
///
///     phistep::PhiStepper stepper{sheet, springs, phistep::velocity_verlet, phistep::mass(m)};
///     const auto report = phistep::preflight(stepper, sheet, 1e-3, {.period = 0.5});
///     if (!report) std::cout << report;      // report.verdict, report.stable_dt, report.terms[k].frequency, …
///
/// The force is linearised at the state, term by term (its own Jacobian, or differences), and its rates are bounded from
/// above: exactly for up to 200 unknowns (r and v counted), by weighted Gershgorin discs beyond (spectral_bound.hpp). So is
/// Δt: stable by guarantee, for the linearised problem; where the stiffness changes, ask again. Nothing is stepped, no
/// count changes, nothing is thrown.
#pragma once

#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <type_traits>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/non_finite.hpp"
#include "phistep/force/seldom.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/run/stepper/phi_stepper.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/study/assess.hpp"
#include "phistep/study/checks/tangent.hpp"
#include "phistep/study/stability/report.hpp"
#include "phistep/study/stability/sampled_method.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// [time] of the shortest impact of those terms that know theirs, by a member contact_time(y); 0 where none does.
template <class F, class View>
[[nodiscard]] double shortest_contact(F& force, const View& y) {
  double shortest = 0;
  for_each_summand(force, [&](auto& term) {
    if constexpr (requires { term.contact_time(y); })
      if (const auto one = static_cast<double>(term.contact_time(y)); one > 0 && (shortest == 0 || one < shortest))
        shortest = one;
  });
  return shortest;
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
    const auto masses = bind_masses<S>(stepper.mass(), y);
    if (algebraic_component(masses))
      throw std::invalid_argument("M is singular: preflight judges no differential-algebraic equations.");
    using Rhs = RightHandSide<S, std::reference_wrapper<Whole>, std::remove_cvref_t<decltype(masses)>>;
    double largest_mass = 1;
    LinearisedProblem problem;
    problem.masses = preflight_masses<S>(y, masses, largest_mass);
    problem.block = particle_rows<S, typename Rhs::Traits>(y);
    problem.tolerance = 64 * std::sqrt(static_cast<double>(std::numeric_limits<Scalar>::epsilon()));
    const auto t = static_cast<Scalar>(options.t), step = static_cast<Scalar>(valid ? dt : 0);
    const double lightest = problem.masses.lumped.size() > 0 ? problem.masses.lumped.minCoeff() : 1;
    const auto linearise = [&](auto& part, const auto& memory) {
      return tangent_of<S>(part, t, step, y, masses, memory, largest_mass, lightest);
    };
    if constexpr (is_sum<Whole>) {
      const auto add = [](Tangent& sum, const Tangent& part) {
        if (sum.C.rows() == 0) sum = part;
        else sum = {sum.K + part.K, sum.C + part.C, sum.known && part.known, sum.finite && part.finite};
      };
      double stiffest = 0;
      for_each_term(force, stepper.memory(), [&](auto k, auto& part, const auto& memory) {
        constexpr bool kick = is_split<Whole, Scheme> && is_kick<std::tuple_element_t<k(), decltype(force.terms)>>;
        const Tangent tangent = linearise(part, memory);
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
      if (problem.rest.C.rows() == 0)
        problem.rest = {SparseRows(problem.whole.K.rows(), problem.whole.K.cols()),
                        SparseRows(problem.whole.C.rows(), problem.whole.C.cols())};
    } else {
      problem.whole = problem.rest = linearise(force, stepper.memory());
    }
    PreflightOptions asked = options;
    if (asked.contact_time == 0) asked.contact_time = shortest_contact(force, Blocks<S>::view(y, masses));
    problem.inner = method_of(stepper.scheme());
    const Method method = problem.slow.empty() ? problem.inner : describe_slow(problem, report);
    Assessment<>{problem, method, scheme_name(stepper.scheme()), asked, report}.run();
  } catch (const std::exception& error) {
    report.verdict = valid ? Verdict::unknown : Verdict::invalid;
    report.finding = error.what();
  }
  return report;
}
/// Of a stepper around a stepper: what the one inside does.
template <class Stepper, State S>
  requires requires(Stepper& outer) { outer.stepper(); }
[[nodiscard]] PreflightReport preflight(Stepper& outer, const S& state, double dt,
                                        const PreflightOptions& options = {}) {
  return preflight(outer.stepper(), state, dt, options);
}

}}  // namespace phistep::PHISTEP_ABI
