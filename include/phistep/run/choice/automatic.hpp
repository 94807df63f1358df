/// @file
/// integrate without a stepper: the scheme is chosen, and changed where stiffness comes or goes:
///
///     auto report = phistep::integrate(y, robertson, {0.0, 1e11}, phistep::tolerance{.rtol = 1e-6, .atol = 1e-14});
///     std::cout << report;      // how it went, which schemes it took, when and why
///
/// It begins with an explicit scheme unless the start is stiff (automatic_stepper.hpp). Observers, events and samples are as
/// with a stepper. For checkpoints, make the stepper yourself: AutomaticStepper and Run.
#pragma once

#include "phistep/base/version.hpp"  // first: it refuses what would break the others

#include <functional>
#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/run/choice/automatic_stepper.hpp"
#include "phistep/run/choice/scheme_uses.hpp"
#include "phistep/run/errors/tolerance.hpp"
#include "phistep/run/run.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Advances y from span.t0 to exactly span.t1, forward or backward, by schemes that it chooses and changes by itself.
/// @param force      f(y), f(y, t), f(r), f(r, v), f(r, v, t), a term or a sum of terms, as for PhiStepper
/// @param mass       mass(m) or capacity(C)
/// @param wanted     the error wanted of the result
/// @param observers  as with a stepper
/// @return outcome, time reached, counts, schemes; on failure y is that of the last good step
template <State S, class F, class MassSpec, class... Observers>
  requires(is_mass_spec<MassSpec>)
AutomaticReport integrate(S& y, F&& force, const MassSpec& mass, TimeSpan<std::type_identity_t<ScalarOf<S>>> span,
                          const tolerance& wanted, Observers&&... observers) {
  auto outside = std::ref(unwrap(force));  // not copied
  AutomaticStepper<S, decltype(outside), MassSpec> stepper{y, outside, wanted.rtol, mass};
  Run<decltype(stepper), S, tolerance, Observers...> run{stepper, y, span, wanted,
                                                         std::forward<Observers>(observers)...};
  return {run.finish(), std::move(stepper).uses()};
}
template <State S, class F, class... Observers>
AutomaticReport integrate(S& y, F&& force, TimeSpan<std::type_identity_t<ScalarOf<S>>> span, const tolerance& wanted,
                          Observers&&... observers) {
  return integrate(y, force, UnitMasses{}, span, wanted, std::forward<Observers>(observers)...);
}

/// No run: says why.
template <State S, class F, class Control, class... Observers>
  requires(!is_mass_spec<std::remove_cvref_t<Control>> && !std::is_convertible_v<Control, const tolerance&>)
AutomaticReport integrate(S&, F&&, TimeSpan<std::type_identity_t<ScalarOf<S>>>, const Control&, Observers&&...) {
  static_assert(!sizeof(Control),
                "phistep: integrate without a stepper chooses dt by its error: tolerance{.rtol = 1e-6}; other controls "
                "take a PhiStepper");
  return {};
}

}}  // namespace phistep::PHISTEP_ABI
