/// @file
/// Which stepper to take, and why: from what the force's type says, the number of unknowns, the tolerance, and the first steps
/// of a run that chooses by itself (choice/automatic_stepper.hpp).
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
#include <type_traits>

#include "phistep/choice/advised_problem.hpp"
#include "phistep/choice/automatic_stepper.hpp"
#include "phistep/control/tolerance.hpp"
#include "phistep/core/version.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/run.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/study/advice.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The beginning of an automatic run, until it changes to an implicit scheme, or a tenth of it is done, or 200 steps, after which
/// the choice hardly changes.
/// @param scene  gains what the run has counted
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
  AdvisedProblem scene = scene_of<S, F>(y, mass, wanted.rtol);
  Stiffness stiffness;
  if constexpr (!SchemesFor<Plain, F, MassSpec>::Rhs::has_history) try {
      const Stiffness found = begin_automatic_run(y, unwrap(force), span, wanted, scene, mass);
      stiffness = found;               // g++ 12 would build it in place, and leave half of it where the force throws
    } catch (const std::exception&) {  // the force threw: then nothing is known of its stiffness
    }
  return decide(scene, stiffness);
}

}}  // namespace phistep::PHISTEP_ABI
