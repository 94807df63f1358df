/// @file
/// Velocity Verlet's kicks and drifts in more than one turn, for motion under a force that ignores v, with a constant mass:
///
///     v ← v + b_i Δt M⁻¹Ψ(t, r),   r ← r + a_i Δt v,   t ← t + a_i Δt,   i = 1 … s,   then a last kick b_{s+1}    (1)
///
/// Symmetric (b and a read the same from behind) and symplectic: no energy drifts away, over any time. The last Ψ is the
/// next step's first, so that a step calls the force s times. The coefficients, SRKN6b and SRKN11b, are those of S. Blanes &
/// P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313, tables 2 and 3; the centre is what the others leave of ½ or 1.
///
/// Some a_i, b_i are negative, as they must be beyond order 2: with friction a step backward in time would feed what it
/// should damp. Hence forces that ignore v only; for others see composed.hpp. Up to which ωΔt nothing grows: docs/stability.md.
#pragma once

#include <cstddef>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/kernel/scheme_on.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// Coefficients of symmetric compositions, which read the same from behind: a table has those up to the centre.

/// Coefficient i of n that sum to one: those given, from both ends, and in the centre what they leave.
template <class Scalar, std::size_t given>
[[nodiscard]] constexpr Scalar symmetric_coefficient(const long double (&coefficients)[given], std::size_t n,
                                                     std::size_t i) {
  const std::size_t from_end = i < n - 1 - i ? i : n - 1 - i;
  if (from_end < given) return static_cast<Scalar>(coefficients[from_end]);
  Scalar sum{0};
  for (const long double x : coefficients) sum += static_cast<Scalar>(x);
  return n % 2 == 1 ? 1 - 2 * sum : Scalar{0.5L} - sum;
}

/// (1) with a table's coefficients: kicks b_1 … from the first to the centre, drifts a_1 … likewise.
template <class Table>
struct KickDrift {
  static constexpr SchemeFacts facts = ExplicitMotion{.is_symplectic = true, .energy = EnergyBalance::rest};
  [[nodiscard]] static constexpr int order() { return Table::order; }
  [[nodiscard]] static constexpr const char* name() { return Table::name; }
};

struct Srkn6b {
  static constexpr const char* name = "srkn6b";
  static constexpr int order = 4;
  static constexpr std::size_t drifts = 6;
  static constexpr long double b[] = {.0829844064174052L, .396309801498368L, -.0390563049223486L};
  static constexpr long double a[] = {.245298957184271L, .604872665711080L};
};
struct Srkn11b {
  static constexpr const char* name = "srkn11b";
  static constexpr int order = 6;
  static constexpr std::size_t drifts = 11;
  static constexpr long double b[] = {.0414649985182624L, .198128671918067L, -.0400061921041533L, .0752539843015807L,
                                      -.0115113874206879L};
  static constexpr long double a[] = {.123229775946271L, .290553797799558L, -.127049212625417L, -.246331761062075L,
                                      .357208872795928L};
};

/// Order 4, six force calls a step.
inline constexpr KickDrift<Srkn6b> srkn6b{};
/// Order 6, eleven force calls a step.
inline constexpr KickDrift<Srkn11b> srkn11b{};

template <class Table, State S>
class SchemeOn<KickDrift<Table>, S> : public SchemeDefaults {
  static_assert(Blocks<S>::drifts, "phistep: kicks and drifts need a motion (r, v), not a first-order state");

 public:
  using Scalar = ScalarOf<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs = [] {
    static_assert(
        !Rhs::couples_unknowns,
        "phistep: this composition needs a force that ignores v: write f(r), or a struct with uses_velocity = "
        "false, or take composed(velocity_verlet)");
    return KernelNeeds{.position = false, .carries = can_carry<Rhs>};
  }();

  SchemeOn(KickDrift<Table>, const auto& /*y*/) {}
  [[nodiscard]] static int order() { return Table::order; }

  /// (1)
  [[nodiscard]] static Outcome step(auto& eq) {
    const Scalar dt = eq.dt;
    Scalar t = eq.t + drift(0) * dt;
    if (const Outcome bad = eq.kick_drift(Advance{kick(0) * dt, Zero{}, drift(0) * dt}); failed(bad)) return bad;
    for (std::size_t i = 1; i < Table::drifts; ++i) {
      eq.evaluate(t, eq.next);
      const Advance by{kick(i) * dt, Zero{}, drift(i) * dt};
      if (!advance_blocks<S>(eq.next, eq.next, by, RateOf<S>::blocks(std::as_const(eq.psi)), eq.psi, eq.rhs().masses()))
        return Outcome::non_finite_state;
      t += drift(i) * dt;
    }
    return eq.kick(kick(Table::drifts) * dt, eq.t + dt);
  }

  /// a_{i+1}
  [[nodiscard]] static constexpr Scalar drift(std::size_t i) {
    return symmetric_coefficient<Scalar>(Table::a, Table::drifts, i);
  }
  /// b_{i+1}
  [[nodiscard]] static constexpr Scalar kick(std::size_t i) {
    return symmetric_coefficient<Scalar>(Table::b, Table::drifts + 1, i);
  }
};

}}  // namespace phistep::PHISTEP_ABI
