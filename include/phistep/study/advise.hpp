/// @file
/// Which stepper to take, and why: from what the force's type says, the number of unknowns, the tolerance, and the first steps
/// of a run that chooses by itself (run/choice/automatic_stepper.hpp).
///
///     const auto advice = phistep::advise(y, robertson, {0.0, 1e11}, {.rtol = 1e-6, .atol = 1e-14});
///     std::cout << advice;             // the line of code to write, and the reasons; advice.scheme, advice.stiffness, …
///
/// It takes as many steps as a tenth of that run has, at most, or a dozen; neither state nor force is changed, nothing is
/// thrown. The rules are those of the run-time-against-error diagrams (bench/work_precision), not of taste.
#pragma once

#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/embed/number_parts.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/run/choice/automatic_stepper.hpp"
#include "phistep/run/choice/scheme_set.hpp"
#include "phistep/run/choice/suitable_scheme.hpp"
#include "phistep/run/control/run_report.hpp"
#include "phistep/run/errors/tolerance.hpp"
#include "phistep/run/run.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What the first steps of an automatic run found.
struct Stiffness {
  bool known = false;
  bool is_stiff = false;   ///< stability limits explicit steps, or would from the first on
  double rate = 0;         ///< [1/time] |λ|max of ∂y'/∂y where it was last computed
  double dt = 0;           ///< [time] of the steps there
  double turns = 0;        ///< rate times the whole span
  std::int64_t steps = 0;  ///< done to find it out
  double covered = 0;      ///< share of the span that they covered
  std::string doubts{};    ///< RunReport::doubts of that run
};

/// A stepper to take, and why.
struct Advice {
  std::string scheme;                 ///< "rodas5p", …
  std::string solver;                 ///< "phistep::newton<…>()"; empty: the library's own choice
  std::string control;                ///< "phistep::tolerance{.rtol = 1e-06}" or "phistep::fixed(dt)"
  std::vector<std::string> reasons;   ///< a sentence each
  std::vector<std::string> warnings;  ///< what the tolerance or the scene does not bear
  Stiffness stiffness;                ///< what was measured along the solution

  /// The lines of code.
  [[nodiscard]] std::string code() const {
    return "phistep::PhiStepper stepper{state, force, phistep::" + scheme + (solver.empty() ? "" : ", ") + solver +
           "};\nphistep::integrate(stepper, state, {t0, t1}, " + control + ");\n";
  }
  [[nodiscard, gnu::cold]] std::string message() const {
    std::string text = code();
    for (const std::string& reason : reasons) text += "  because " + reason + "\n";
    for (const std::string& warning : warnings) text += "  but " + warning + "\n";
    return text;
  }
  friend auto& operator<<(TextStream auto& out, const Advice& advice) {
    out << advice.message();
    return out;
  }
};

template <class = void>
[[nodiscard]] Advice decide(const AdvisedProblem& scene, const Stiffness& stiffness) {
  Advice to;
  to.stiffness = stiffness;
  to.control = "phistep::tolerance{.rtol = " + number_text(scene.rtol, 3) + "}";
  const double u = std::pow(10.0, -scene.digits);
  const std::string wanted = "a tolerance of " + number_text(scene.rtol, 3);
  if (scene.rtol < 10 * u)
    to.warnings.push_back(wanted + " is below what a number of " + std::to_string(scene.digits) + " digits can hold");
  const SuitableScheme scheme = suitable_scheme(scene, stiffness.is_stiff);
  if (scene.has_history) to.control = "phistep::fixed(dt)";
  else if (stiffness.known) {
    std::string text = stiffness.is_stiff ? "it is stiff: " : "it is not stiff: ";
    text += "|lambda| = " + number_text(stiffness.rate, 3);
    text += !stiffness.is_stiff   ? ", and the error limits steps to dt = "
            : stiffness.steps > 0 ? " limits explicit steps to dt = "
                                  : ", where the error allows dt = ";
    text += number_text(stiffness.dt, 3) + " (seen: " + std::to_string(stiffness.steps) + " steps, the first " +
            number_text(100 * stiffness.covered, 3) + " % of the span)";
    to.reasons.push_back(text);
  } else {
    to.warnings.push_back("how stiff it is could not be found out: the run's first steps failed");
  }
  if (!stiffness.doubts.empty()) to.warnings.push_back("the run looked at was odd:" + stiffness.doubts);
  to.scheme = name_of(scheme);
  if (is_by_krylov(scheme)) to.solver = "phistep::newton<phistep::PreconditionedBySymmetry>()";
  to.reasons.push_back(sentence_of(scheme, scene, wanted));
  if (scheme == SuitableScheme::tr_bdf_2 && scene.structure != Structure::network)
    to.warnings.push_back("a member jacobian(...), or sparsity(force, pattern), would open the way to rodas5p");
  const double periods = stiffness.turns / 6.283185307179586;
  if ((scheme == SuitableScheme::nystrom_8 || scheme == SuitableScheme::nystrom_12) && periods > 1e4)
    to.warnings.push_back(
        "over " + number_text(periods, 3) +
        " of its fastest periods the energy drifts with a varying dt: srkn11b with a fixed dt keeps it");
  return to;
}

/// Does the beginning of an automatic run: until it changes to an implicit scheme, or a tenth of it is done, or 200 steps. After
/// that the choice hardly changes.
/// @param scene  gets the counts of the run
template <State S, class F, class MassSpec>
[[nodiscard]] Stiffness begin_automatic_run(S& y, F& force, TimeSpan<ScalarOf<S>> span, const tolerance& wanted,
                                            AdvisedProblem& scene, const MassSpec& mass) {
  constexpr std::int64_t fewest = 12, most = 200;
  auto outside = std::ref(force);
  AutomaticStepper<S, decltype(outside), MassSpec> stepper{y, outside, scene, mass};
  Run run{stepper, y, span, wanted};
  const double whole = std::abs(static_cast<double>(span.t1 - span.t0));
  Stiffness found;
  for (double left = whole; run.advance(); ++found.steps) {
    found.known = true;
    const double before = left;
    left = std::abs(static_cast<double>(span.t1 - run.time()));
    const double done = static_cast<double>(found.steps + 1), to_come = left / (before - left);
    if (stepper.is_stiff() || found.steps >= most || (found.steps >= fewest && done > 0.1 * (done + to_come))) break;
  }
  found.known = found.known || whole == 0;
  found.doubts = run.report().doubts();
  scene = stepper.problem();
  const RateSeen& seen = stepper.seen();
  found.is_stiff = stepper.is_stiff();
  found.rate = seen.rate, found.dt = seen.dt, found.turns = seen.rate * whole;
  found.covered = whole > 0 ? std::abs(static_cast<double>(run.time() - span.t0)) / whole : 1;
  return found;
}

/// The scheme and the control to take for a run, with reasons, from the types and from the run's first steps.
/// @param start   [the state's units] where the run begins
/// @param force   as the stepper will have it; called, not changed
/// @param wanted  what the run will be asked for
template <State S, class F, class MassSpec = UnitMasses>
[[nodiscard]] Advice advise(const S& start, F force, TimeSpan<std::type_identity_t<ScalarOf<S>>> span,
                            const tolerance& wanted = {}, const MassSpec& mass = {}) {
  using Plain = PlainState<S>;
  Plain y;
  copy_blocks<S>(y, start);
  if (algebraic_component(bind_masses<S>(mass, y)))
    throw std::invalid_argument(
        "phistep: M is singular: advise compares no schemes for differential-algebraic equations; take rodas5p or "
        "rodas4p2");
  AdvisedProblem scene = SchemesFor<S, F, MassSpec>::scene(y, wanted.rtol);
  Stiffness stiffness;
  if constexpr (!SchemesFor<S, F, MassSpec>::Rhs::has_history) try {
      auto&& stepped = as_stepped<S>(unwrap(force));
      const Stiffness found = begin_automatic_run(y, stepped, span, wanted, scene, mass);
      stiffness = found;               // g++ 12 would build it in place, and leave half of it where the force throws
    } catch (const std::exception&) {  // the force threw: then nothing is known of its stiffness
    }
  return decide(scene, stiffness);
}

}}  // namespace phistep::PHISTEP_ABI
