/// @file
/// The rules by which a stepper is advised, and the advice as text.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/study/report.hpp"
#include "phistep/study/stiffness.hpp"

namespace phistep::inline PHISTEP_ABI {

/// What the choice depends on, beside the stiffness.
struct AdvisedProblem {
  std::int64_t unknowns = 0;  ///< solved for: n for a motion, whose r and v are 2n numbers
  bool is_motion = false, uses_velocity = false, has_history = false, has_jacobian = false, has_pattern = false;
  Structure structure = Structure::dense;
  double rtol = 1e-4;
  int digits = 15;  ///< of the scalar
};

/// A stepper to take, and why.
struct Advice {
  std::string scheme;                 ///< "rodas5p", …
  std::string control;                ///< "phistep::tolerance{.rtol = 1e-06}" or "phistep::fixed(dt)"
  std::vector<std::string> reasons;   ///< a sentence each
  std::vector<std::string> warnings;  ///< what the tolerance or the scene does not bear
  Stiffness stiffness;                ///< what was measured along the solution

  /// The lines of code.
  [[nodiscard]] std::string code() const {
    return "phistep::PhiStepper stepper{state, force, phistep::" + scheme +
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

/// Up to here a matrix is dense in the caches, and its factors cost as much as a few force calls.
inline constexpr std::int64_t few_unknowns = 50;

namespace advice_rules {

template <class = void>
[[nodiscard]] std::string digits_of(double rtol) {
  return "a tolerance of " + short_number(rtol);
}

/// The largest rtol at which radau's orders pay for its iterations, 0 where they never do: the 1-D Brusselator of 100 to 1e4
/// points (bands), reaction and diffusion on grids of 400 to 3600 (sparse), the small problems of bench/work_precision (dense).
[[nodiscard]] constexpr double radau_from(const AdvisedProblem& scene) {
  if (scene.structure == Structure::sparse) return 1e-4;
  if (scene.structure != Structure::dense) return 1e-6;
  return scene.unknowns <= 10 ? 3e-4 : scene.unknowns <= few_unknowns ? 1e-7 : 0;
}

/// Stiff: who solves linear equations, and how many digits are wanted.
template <class = void>
void choose_stiff(const AdvisedProblem& scene, Advice& to) {
  if (scene.structure == Structure::network) {
    to.scheme = "tr_bdf2";
    to.reasons.push_back(
        "its bonds are solved by conjugate gradients, which serve schemes that resolve; TR-BDF2 damps what it "
        "can't resolve");
  } else if (!scene.has_jacobian && !scene.has_pattern && scene.unknowns > few_unknowns) {
    to.scheme = "tr_bdf2";
    to.reasons.push_back("it has neither a Jacobian nor a pattern: one of " + std::to_string(scene.unknowns) +
                         " unknowns by differences costs as many force calls, and TR-BDF2 keeps it for many steps");
    to.warnings.push_back("a member jacobian(...), or sparsity(force, pattern), would open the way to rodas5p");
  } else if (scene.rtol > 3e-4) {
    to.scheme = "rodas4";
    to.reasons.push_back("for few digits, six linear solves with one matrix and no iteration are the cheapest step");
  } else if (scene.rtol <= radau_from(scene)) {
    to.scheme = "radau";
    to.reasons.push_back("at " + digits_of(scene.rtol) + " and " + std::to_string(scene.unknowns) +
                         " unknowns Radau's orders 5, 9 and 13 are ahead");
  } else {
    to.scheme = "rodas5p";
    to.reasons.push_back("with " + std::to_string(scene.unknowns) +
                         " unknowns the factorization is what costs: order 5 has one for eight solves");
  }
}
/// Not stiff: what the force looks at, and how many digits are wanted.
template <class = void>
void choose_explicit(const AdvisedProblem& scene, Advice& to) {
  if (!scene.is_motion || scene.uses_velocity) {
    const bool few_digits = scene.rtol > 3e-5;
    to.scheme = few_digits ? "tsit5" : "dop853";
    to.reasons.push_back(std::string(scene.is_motion ? "its force depends on v" : "it is of first order") +
                         ": an explicit Runge-Kutta pair of order " + (few_digits ? "5" : "8") +
                         " needs the fewest force calls at " + digits_of(scene.rtol));
    return;
  }
  const double periods = to.stiffness.turns / 6.283185307179586;
  if (scene.rtol >= 1e-3 && scene.unknowns > 1000) {
    to.scheme = "velocity_verlet";
    to.reasons.push_back(
        "many particles at few digits: one force call a step, and a bounded error of the energy at fixed dt");
    return;
  }
  to.scheme = scene.rtol > 1e-8 ? "rkn86" : "rkn1210";
  to.reasons.push_back("its force ignores v: a Runge-Kutta-Nystrom pair of order " +
                       std::string(scene.rtol > 1e-8 ? "8" : "12") + " needs the fewest force calls at " +
                       digits_of(scene.rtol));
  if (periods > 1e4)
    to.warnings.push_back(
        "over " + short_number(periods) +
        " of its fastest periods the energy drifts with a varying dt: srkn11b with a fixed dt keeps it");
}

}  // namespace advice_rules

/// The choice. Ratios and digits are where the diagrams of bench/work_precision cross.
template <class = void>
[[nodiscard]] Advice decide(const AdvisedProblem& scene, const Stiffness& stiffness) {
  Advice to;
  to.stiffness = stiffness;
  to.control = "phistep::tolerance{.rtol = " + short_number(scene.rtol) + "}";
  const double u = std::pow(10.0, -scene.digits);
  if (scene.rtol < 10 * u)
    to.warnings.push_back(advice_rules::digits_of(scene.rtol) + " is below what a number of " +
                          std::to_string(scene.digits) + " digits can hold");
  if (scene.has_history) {
    to.scheme = "velocity_verlet";
    to.control = "phistep::fixed(dt)";
    to.reasons.push_back(
        "its force has a history (contacts, friction): steps that resolve an impact, of equal length; "
        "phistep::preflight says how long");
    return to;
  }
  const bool stiff = stiffness.known && stiffness.ratio() > 3;
  if (stiffness.known) {
    std::string text = stiff ? "it is stiff: " : "it is not stiff: ";
    text += "|lambda| goes up to " + short_number(stiffness.rate) +
            " along the solution, where an explicit scheme would need " + short_number(stiffness.turns / 3) +
            " steps to be stable, and an implicit one " + short_number(stiffness.steps) + " to be right to " +
            short_number(stiffness.tolerance);
    if (stiffness.covered < 1) text += " (seen: the first " + short_number(100 * stiffness.covered) + " % of the span)";
    to.reasons.push_back(text);
  } else {
    to.warnings.push_back("how stiff it is could not be found out: the pilot did not get anywhere");
  }
  if (stiff) advice_rules::choose_stiff(scene, to);
  else advice_rules::choose_explicit(scene, to);
  return to;
}

}  // namespace phistep::inline PHISTEP_ABI
