/// @file
/// Which stepper to take, and why: from what the force's type says, the number of unknowns, the tolerance, and a pilot run
/// that finds out how stiff the problem is.
///
///     const auto advice = phistep::advise(y, robertson, {0.0, 1e11}, {.rtol = 1e-6, .atol = 1e-14});
///     std::cout << advice;             // the line of code to write, and the reasons; advice.scheme, advice.stiffness, …
///
/// The pilot takes at most 400 coarse steps; neither state nor force is changed, nothing is thrown. The rules are those of
/// the run-time-against-error diagrams (bench/work_precision), not of taste.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "phistep/control/error_norm.hpp"
#include "phistep/control/spectral_radius.hpp"
#include "phistep/control/tolerance.hpp"
#include "phistep/equation/right_hand_side.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/jacobian/differences.hpp"
#include "phistep/run.hpp"
#include "phistep/schemes/advised_problem.hpp"
#include "phistep/schemes/tr_bdf2.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"
#include "phistep/step/phi_stepper.hpp"
#include "phistep/study/advice.hpp"
#include "phistep/study/stiffness.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Coarse steps of TR-BDF2 along the solution, and ρ at some of them.
template <State S, class F, class MassSpec>
[[nodiscard]] Stiffness probe_stiffness(const S& start, F& force, TimeSpan<ScalarOf<S>> span, tolerance wanted,
                                        const MassSpec& mass) {
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  Stiffness found;
  PhiStepper pilot{start, std::ref(force), tr_bdf2, mass};
  Plain y;
  copy_blocks<S>(y, start);
  Plain at = y, weight = y;
  wanted.atol = wanted.atol.scaled(found.tolerance / wanted.rtol);
  wanted.rtol = found.tolerance;
  wanted.filter = StepFilter::automatic;
  wanted.max_steps = 400;
  ErrorNorm<Plain> norm;
  if (!norm.begin(wanted, y)) return found;
  SpectralRadius<Plain> radius{y};
  const auto slope = [&pilot](Scalar t, const Plain& x, Plain& out) { return pilot.slope(t, x, out); };
  PhiStepper stepper{y, std::ref(force), tr_bdf2, mass};
  Run run{stepper, y, span, wanted};
  double rho = 0;
  for (std::int64_t step = 0; !run.has_ended(); ++step) {
    const Scalar before = run.time();
    // Where steps grow by decades, so may ρ change: each of the first, then each fourth.
    if (step < 16 || step % 4 == 0) {
      copy_blocks<S>(at, y);
      norm.weigh(at, weight);
      rho = radius(slope, before, at, weight, wanted.rtol, step == 0 ? 8 : 3);
      found.rate = std::max(found.rate, rho);
    }
    if (!run.advance()) break;
    found.steps += 1;
    found.turns += rho * std::abs(static_cast<double>(run.time() - before));
  }
  const double whole = std::abs(static_cast<double>(span.t1 - span.t0));
  found.covered = whole > 0 ? std::abs(static_cast<double>(run.time() - span.t0)) / whole : 1;
  found.known = found.steps > 0;
  if (found.covered > 0 && found.covered < 1) {
    found.steps /= found.covered;
    found.turns /= found.covered;
  }
  return found;
}

/// The scheme and the control to take for a run, with reasons, from the types and from a pilot run.
/// @param start   [the state's units] where the run begins
/// @param force   as the stepper will have it; called, not changed
/// @param wanted  what the run will be asked for
template <State S, class F, class MassSpec = UnitMasses>
[[nodiscard]] Advice advise(const S& start, F force, TimeSpan<std::type_identity_t<ScalarOf<S>>> span,
                            const tolerance& wanted = {}, const MassSpec& mass = {}) {
  PlainState<S> y;
  copy_blocks<S>(y, start);
  if (is_singular(bind_masses<S>(mass, y)))
    throw std::invalid_argument(
        "phistep: M is singular: advise compares no schemes for differential-algebraic equations; take rodas5p or "
        "rodas4");
  AdvisedProblem scene = scene_of<S, F>(y, mass);
  scene.rtol = wanted.rtol;
  Stiffness stiffness;
  try {
    stiffness = probe_stiffness(start, unwrap(force), span, wanted, mass);
  } catch (const std::exception&) {  // a Jacobian too large to be formed: then nothing is known of its stiffness
  }
  return decide(scene, stiffness);
}

}  // namespace phistep::inline PHISTEP_ABI
