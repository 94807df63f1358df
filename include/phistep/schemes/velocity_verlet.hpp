/// @file
/// Velocity Verlet: the pair (φ_force, φ_drift) = (0, 1) over Δt/2, then (1, 0) over Δt/2 (phi.hpp),
///
///     v½ = v + ½Δt M⁻¹Ψ(t, r, v),   r⁺ = r + Δt v½,                                                             (1)
///     v⁺ = v½ + ½Δt M⁻¹Ψ(t+Δt, r⁺, v⁺)                  a resolve for v alone where Ψ depends on v              (2)
///
/// Its local error: of r, −Δt³/6 r‴ = −Δt²/6 (a⁺ − a); of v that of the trapezoidal rule.
#pragma once

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/base/version.hpp"
#include "phistep/schemes/error_estimate.hpp"
#include "phistep/step/kernel/scheme_on.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Velocity Verlet: (0,1) over Δt/2, then (1,0) over Δt/2, fused. Order 2; symplectic where the force ignores v.
struct VelocityVerlet {
  static constexpr SchemeFacts facts = ExplicitMotion{.is_symplectic = true, .energy = EnergyBalance::verlet};
  [[nodiscard]] static constexpr const char* name() { return "velocity_verlet"; }
  [[nodiscard]] static constexpr int order() { return 2; }
};

/// The usual choice for explicit motion: one force call a step, order 2, bounded energy error.
inline constexpr VelocityVerlet velocity_verlet{};

/// Without velocities nothing is solved, and its second Ψ is the next step's first.
template <State S>
class SchemeOn<VelocityVerlet, S> : public SchemeDefaults {
 public:
  template <class Rhs>
  static constexpr KernelNeeds needs{.solver = Rhs::couples_unknowns,
                                     .position = false,
                                     .carries = !Rhs::couples_unknowns && can_carry<Rhs>,
                                     .passes = Rhs::couples_unknowns ? 0 : 2};
  static constexpr bool traces = true;

  SchemeOn(VelocityVerlet, const auto& /*y*/) {}
  [[nodiscard]] static VelocityVerlet scheme() { return {}; }
  [[nodiscard]] static int order() { return VelocityVerlet::order(); }
  [[nodiscard]] static bool estimates(const auto& trace) { return trace.dt_before != 0; }

  template <class Kernel, class Step>
  [[nodiscard]] static Outcome step(Kernel& kernel, Step& step) {
    const ScalarOf<S> dt = step.dt, half = dt / 2;
    if (const Outcome bad = kernel.kick_drift(step, Advance{half, Zero{}, dt}); failed(bad)) return bad;  // (1)
    if constexpr (Step::is_traced) {
      assign_solved<S>(step.trace.start, (in<S>(step.next) - in<S>(step.y)) / half);
      position_of<S>(step.trace.start) = velocity_of<S>(step.y);
      // The second half kick is predicted to be the first.
      assign<S>(step.trace.predicted, in<S>(step.next) + (in<S>(step.next) - in<S>(step.y)));
      step.has_prediction = true;
    }
    step.psi_next_known = Kernel::carries;
    if (const Outcome bad = kernel.resolve(step, {half, 0}, step.t + dt); failed(bad)) return bad;  // (2)
    return error(kernel, step);
  }

 private:
  template <class Kernel, class Step>
  [[nodiscard]] static Outcome error(Kernel& kernel, Step& step) {
    if constexpr (Step::is_traced) {
      auto& trace = step.trace;
      trace.has_slopes = true;
      trace.has_error = estimates(trace);
      if (!trace.has_error) return Outcome::success;
      assign_solved<S>(trace.error, milne(trace, step.dt));
      position_of<S>(trace.error) =
          (-step.dt * step.dt / 6) * (velocity_of<S>(trace.end) - velocity_of<S>(trace.start));
      if (needs<typename Kernel::Rhs>.solver) return kernel.filter(trace.error);
    }
    return Outcome::success;
  }
};

}}  // namespace phistep::PHISTEP_ABI
