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
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/transaction/trace.hpp"

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
  [[nodiscard]] static int order() { return VelocityVerlet::order(); }
  [[nodiscard]] static bool estimates(const auto& trace) { return trace.dt_before != 0; }

  [[nodiscard, gnu::always_inline]] static inline Outcome step(auto& eq) {
    const ScalarOf<S> dt = eq.dt, half = dt / 2;
    if (const Outcome bad = eq.kick_drift(Advance{half, Zero{}, dt}); failed(bad)) return bad;  // (1)
    return eq.resolve({half, 0}, eq.t + dt);                                                    // (2)
  }
  [[nodiscard]] static Outcome error(auto& eq) {
    auto& trace = eq.trace;
    trace.has_slopes = true;
    trace.has_error = estimates(trace);
    if (!trace.has_error) return Outcome::success;
    assign_solved<S>(trace.error, milne(trace, eq.dt));
    position_of<S>(trace.error) = (-eq.dt * eq.dt / 6) * (velocity_of<S>(trace.end) - velocity_of<S>(trace.start));
    return eq.filter(trace.error);
  }
};

}}  // namespace phistep::PHISTEP_ABI
