/// @file
/// A stepper that is advised, with reasons, as text.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "phistep/choice/suitable_scheme.hpp"
#include "phistep/core/version.hpp"
#include "phistep/study/report.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What the first steps of an automatic run found.
struct Stiffness {
  bool known = false;
  bool is_stiff = false;   ///< stability limits explicit steps, or would from the first on
  double rate = 0;         ///< [1/time] |λ|max of ∂y'/∂y where it was looked at last
  double dt = 0;           ///< [time] of the steps there
  double turns = 0;        ///< rate times the whole span
  std::int64_t steps = 0;  ///< done to find it out
  double covered = 0;      ///< share of the span that they covered
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
  [[nodiscard]] std::string message() const {
    std::string text = code();
    for (const std::string& reason : reasons) text += "  because " + reason + "\n";
    for (const std::string& warning : warnings) text += "  but " + warning + "\n";
    return text;
  }
  template <class OStream>
    requires requires(OStream& out, const std::string& text) { out << text; }
  friend OStream& operator<<(OStream& out, const Advice& advice) {
    out << advice.message();
    return out;
  }
};

/// The choice.
template <class = void>
[[nodiscard]] Advice decide(const AdvisedProblem& scene, const Stiffness& stiffness) {
  Advice to;
  to.stiffness = stiffness;
  to.control = "phistep::tolerance{.rtol = " + short_number(scene.rtol) + "}";
  const double u = std::pow(10.0, -scene.digits);
  const std::string wanted = "a tolerance of " + short_number(scene.rtol);
  if (scene.rtol < 10 * u)
    to.warnings.push_back(wanted + " is below what a number of " + std::to_string(scene.digits) + " digits can hold");
  const SchemeChoice choice = suitable_scheme(scene, stiffness.is_stiff);
  if (choice.why == SchemeReason::history) to.control = "phistep::fixed(dt)";
  else if (stiffness.known) {
    std::string text = stiffness.is_stiff ? "it is stiff: " : "it is not stiff: ";
    text += "|lambda| = " + short_number(stiffness.rate);
    text += stiffness.is_stiff ? " limits explicit steps to dt = " : ", and the error limits steps to dt = ";
    text += short_number(stiffness.dt) + " (seen: " + std::to_string(stiffness.steps) + " steps, the first " +
            short_number(100 * stiffness.covered) + " % of the span)";
    to.reasons.push_back(text);
  } else {
    to.warnings.push_back("how stiff it is could not be found out: the run's first steps failed");
  }
  to.scheme = name_of(choice.scheme);
  if (is_by_krylov(choice.scheme)) to.solver = "phistep::newton<phistep::PreconditionedBySymmetry>()";
  to.reasons.push_back(sentence_of(choice, scene, wanted));
  if (choice.why == SchemeReason::no_jacobian)
    to.warnings.push_back("a member jacobian(...), or sparsity(force, pattern), would open the way to rodas5p");
  const double periods = stiffness.turns / 6.283185307179586;
  if (choice.why == SchemeReason::fewest_calls_motion && periods > 1e4)
    to.warnings.push_back(
        "over " + short_number(periods) +
        " of its fastest periods the energy drifts with a varying dt: srkn11b with a fixed dt keeps it");
  return to;
}

}}  // namespace phistep::PHISTEP_ABI
