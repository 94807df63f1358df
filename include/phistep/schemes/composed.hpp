/// @file
/// Symmetric compositions, whose coefficients read the same from behind. Velocity Verlet's kicks and drifts in more than one
/// turn, for motion under a force that ignores v, with a constant mass:
///
///     v ← v + b_i Δt M⁻¹Ψ(t, r),   r ← r + a_i Δt v,   t ← t + a_i Δt,   i = 1 … s,   then a last kick b_{s+1}    (1)
///
/// Symplectic: no energy drifts away, over any time. The last Ψ is the next step's first, so that a step calls the force s
/// times. The coefficients, SRKN6b and SRKN11b, are those of S. Blanes & P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313,
/// tables 2 and 3; the centre is what the others leave of ½ or 1. Up to which ωΔt nothing grows: docs/stability.md.
///
/// And a symmetric scheme of order 2, composed with itself to order 8: with Φ_h one of its steps,
///
///     Φ_{γ_17 Δt} ∘ … ∘ Φ_{γ_1 Δt},     γ_{18−i} = γ_i,     Σ γ_i = 1                                            (2)
///
/// W. Kahan & R.-C. Li, Math. Comp. 66 (1997) 1089, the seventeen stages of order 8 (also E. Hairer, C. Lubich & G. Wanner,
/// Geometric Numerical Integration, V.3, eq. 3.11); the centre is what the others leave of 1. For forces that depend on v:
/// magnetic fields, rotating frames, a drive. It solves what the scheme solves: with velocity Verlet a local equation for v in
/// each substep.
///
/// **Not with dissipation.** Some a_i, b_i, γ_i are negative, as they must be beyond order 2: such a substep goes backward in
/// time, and what friction damps forward grows there, by e^{c|γ_i|Δt}; an implicit one meets 1 − φλγ_iΔt = 0. Hence (1) for
/// forces that ignore v only. In (2) friction that is slow beside Δt does no harm, stiff friction blows up: there tr_bdf2 or a
/// Rosenbrock scheme serves.
#pragma once

#include <cstddef>
#include <string>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/schemes/velocity_verlet.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/kernel/scheme_on.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Coefficient i of n that sum to one: those of a table, from both ends, and in the centre what they leave.
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

/// γ_1 … γ_8
struct KahanLi8 {
  static constexpr int order = 8;
  static constexpr std::size_t count = 17;
  static constexpr long double gamma[] = {.13020248308889008088L, .56116298177510838456L,  -.38947496264484728641L,
                                          .15884190655515560090L, -.39590389413323757734L, .18453964097831570709L,
                                          .25837438768632204729L, .29501172360931029887L};
};

/// (2) over a scheme.
template <class Scheme>
struct Composed {
  static constexpr SchemeFacts facts{.motion_only = Scheme::facts.motion_only,
                                     .is_explicit = Scheme::facts.is_explicit,
                                     .is_symplectic = Scheme::facts.is_symplectic,
                                     .is_a_stable = false,  // some substeps go backward
                                     .is_l_stable = false,
                                     .energy = EnergyBalance::rest};
  [[no_unique_address]] Scheme scheme;
  [[nodiscard]] static constexpr int order() { return KahanLi8::order; }
  [[nodiscard]] static std::string name() {
    std::string name = "composed(";  // by +, g++ 12 warns of an overlap that isn't there
    return name.append(Scheme::name()).append(1, ')');
  }
};
/// Velocity Verlet, the trapezoidal rule or the midpoint rule to order 8.
template <class Scheme>
[[nodiscard]] constexpr Composed<Scheme> composed(Scheme scheme) {
  return {scheme};
}

template <class Scheme, State S>
class SchemeOn<Composed<Scheme>, S> : public SchemeDefaults {
  using Inner = SchemeOn<Scheme, S>;
  static_assert(
      !Inner::looks_back,
      "phistep: composed(scheme) takes a scheme that is symmetric in time: velocity_verlet, trapezoidal or midpoint");

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs = [] {
    KernelNeeds inner = Inner::template needs<Rhs>;
    inner.passes = 0;
    return inner;
  }();

  SchemeOn(const Composed<Scheme>& composed, const Plain& y) : inner_{composed.scheme, y}, from_{y} {}
  void resize(const Plain& y) {
    inner_.resize(y);
    from_ = y;
  }
  [[nodiscard]] static int order() { return KahanLi8::order; }

  [[nodiscard]] static bool leaves_force() { return false; }  // the last part has

  [[nodiscard]] Outcome step(auto& eq) {
    copy_blocks<S>(eq.next, eq.y);
    Scalar share{0};
    for (std::size_t i = 0; i < KahanLi8::count; ++i) {
      copy_blocks<S>(from_, eq.next);
      auto part = eq.part(from_, eq.t + share * eq.dt, gamma(i) * eq.dt, eq.next);
      if (const Outcome bad = take_step(inner_, part); failed(bad)) return bad;
      eq.ends_as(part);
      share += gamma(i);
    }
    return Outcome::success;
  }

  [[nodiscard]] static constexpr Scalar gamma(std::size_t i) {
    return symmetric_coefficient<Scalar>(KahanLi8::gamma, KahanLi8::count, i);
  }

 private:
  Inner inner_;
  Plain from_;
};

}}  // namespace phistep::PHISTEP_ABI
