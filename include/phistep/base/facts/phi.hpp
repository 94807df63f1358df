/// @file
/// φ and the schemes of the φ-method, as types.
///
/// A φ known at compile time lets a scheme drop what it doesn't need: `forward_euler` instantiates no solver.
/// Compile-time values are ratios, because clang 14 has no floating-point template parameters.
#pragma once

#include <concepts>
#include <stdexcept>
#include <type_traits>

#include "phistep/base/facts/scheme_facts.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// φ = Numerator/Denominator, known at compile time.
template <int Numerator, int Denominator = 1>
struct FixedPhi {
  static_assert(Denominator > 0 && Numerator >= 0 && Numerator <= Denominator, "phi must lie in [0, 1]");
  template <class Scalar>
  [[nodiscard]] static constexpr Scalar value() {
    return static_cast<Scalar>(Numerator) / static_cast<Scalar>(Denominator);
  }
};

/// φ given at run time, checked once.
class RunTimePhi {
 public:
  /// @throws std::invalid_argument unless 0 ≤ phi ≤ 1 (a NaN fails too).
  explicit constexpr RunTimePhi(double phi) : phi_{phi} {
    if (!(phi >= 0.0 && phi <= 1.0)) throw std::invalid_argument("phistep: phi must lie in [0, 1]");
  }
  /// 1/2 is 0 in C++. @throws std::invalid_argument where an integer is 0
  explicit constexpr RunTimePhi(std::integral auto phi) : RunTimePhi{static_cast<double>(phi)} {
    if (phi == 0)
      throw std::invalid_argument("phistep: phi is the integer 0, as 1/2 is: write 0.5, or 0.0, or forward_euler");
  }
  template <class Scalar>
  [[nodiscard]] constexpr Scalar value() const {
    return static_cast<Scalar>(phi_);
  }

 private:
  double phi_;
};

/// φ_drift of a run-time pair: a type of its own, so that a pair on a first-order state is a compile error.
class RunTimeDriftPhi : public RunTimePhi {
  using RunTimePhi::RunTimePhi;
};

/// True where φ is halves/2 by type.
template <class Phi, int halves>
inline constexpr bool fixes = false;
template <int Numerator, int Denominator, int halves>
inline constexpr bool fixes<FixedPhi<Numerator, Denominator>, halves> = 2 * Numerator == halves* Denominator;

/// True where φ is zero by type, so that nothing implicit needs to exist.
template <class Phi>
inline constexpr bool is_zero_phi = fixes<Phi, 0>;

/// Where Ψ is evaluated: at both ends of the step, blended (docs/method.md), or once at a stage inside it.
enum class Form { endpoint, stage };

/// The φ-method with φ_force weighting Ψ in the velocity (or first-order) update and φ_drift weighting v in r' = v.
template <class Force, class Drift, Form form_>
struct PhiScheme {
  static constexpr Form form = form_;
  static constexpr SchemeFacts facts{
      .motion_only = !std::is_same_v<Force, Drift>,
      .is_explicit = is_zero_phi<Force> || is_zero_phi<Drift>,
      .is_symplectic = (fixes<Force, 0> && fixes<Drift, 2>) || (fixes<Force, 2> && fixes<Drift, 0>) ||
                       (form == Form::stage && fixes<Force, 1>),
      .is_a_stable = std::is_same_v<Force, Drift> && (fixes<Force, 1> || fixes<Force, 2>),
      .is_l_stable = std::is_same_v<Force, Drift> && fixes<Force, 2>,
      .energy = form == Form::stage ? EnergyBalance::stage : EnergyBalance::endpoint};
  [[no_unique_address]] Force force;
  [[no_unique_address]] Drift drift;

  /// Order of convergence: 2 where both weights are ½, else 1.
  [[nodiscard]] constexpr int order() const {
    return force.template value<double>() == 0.5 && drift.template value<double>() == 0.5 ? 2 : 1;
  }
  [[nodiscard]] static constexpr const char* name() {
    constexpr bool stage = form == Form::stage;
    if (fixes<Force, 0> && fixes<Drift, 0>) return "forward_euler";
    if (fixes<Force, 1> && fixes<Drift, 1>) return stage ? "midpoint" : "trapezoidal";
    if (fixes<Force, 2> && fixes<Drift, 2>) return "backward_euler";
    if (fixes<Force, 0> && fixes<Drift, 2>) return "symplectic_euler";
    if (fixes<Force, 2> && fixes<Drift, 0>) return "symplectic_euler_adjoint";
    return facts.motion_only ? "a pair of phi" : stage ? "phi_stage" : "phi";
  }
};

/// One φ for force and drift.
template <class Phi, Form form = Form::endpoint>
using SinglePhi = PhiScheme<Phi, Phi, form>;

/// φ = 0. Order 1. Never stable for undamped motion: the energy of an oscillator grows by 1 + (ωΔt)² each step.
inline constexpr SinglePhi<FixedPhi<0>> forward_euler{};
/// φ = ½ at the two ends: the trapezoidal rule (some call it "midpoint"). Order 2, A-stable; rings on stiff modes.
inline constexpr SinglePhi<FixedPhi<1, 2>> trapezoidal{};
/// φ = 1. Order 1, L-stable: damps what it can't resolve.
inline constexpr SinglePhi<FixedPhi<1>> backward_euler{};
/// φ = ½ at one stage: the implicit midpoint rule. Order 2, symplectic, keeps quadratic invariants such as angular momentum.
inline constexpr SinglePhi<FixedPhi<1, 2>, Form::stage> midpoint{};
/// Kick, then drift: (φ_force, φ_drift) = (0, 1). Order 1, symplectic, explicit.
inline constexpr PhiScheme<FixedPhi<0>, FixedPhi<1>, Form::endpoint> symplectic_euler{};
/// Drift, then kick: (1, 0), the adjoint of symplectic_euler; explicit where the force ignores v.
inline constexpr PhiScheme<FixedPhi<1>, FixedPhi<0>, Form::endpoint> symplectic_euler_adjoint{};

/// φ chosen at run time. @throws std::invalid_argument unless 0 ≤ phi ≤ 1.
[[nodiscard]] constexpr SinglePhi<RunTimePhi> phi(auto phi) { return {RunTimePhi(phi), RunTimePhi(phi)}; }

/// The pair (φ_force, φ_drift) at run time, for motion. @throws std::invalid_argument unless both lie in [0, 1].
/// Newmark's β = φ_force φ_drift, γ = φ_force + φ_drift − ½ (numerically the same positions).
[[nodiscard]] constexpr auto phi(double phi_force, double phi_drift) {
  return PhiScheme<RunTimePhi, RunTimeDriftPhi, Form::endpoint>{RunTimePhi{phi_force}, RunTimeDriftPhi{phi_drift}};
}

/// φ at run time in stage form: Ψ is evaluated once, at t + φΔt. @throws std::invalid_argument unless 0 ≤ phi ≤ 1.
[[nodiscard]] constexpr SinglePhi<RunTimePhi, Form::stage> phi_stage(auto phi) {
  return {RunTimePhi(phi), RunTimePhi(phi)};
}

/// φ = 1/(1+ρ∞): stiff modes shrink by the factor ρ∞ each step (1: trapezoidal, 0: backward Euler). Of order 1 where ρ∞ < 1;
/// generalized_alpha(ρ∞) damps them as much at order 2.
/// @throws std::invalid_argument unless 0 ≤ rho_inf ≤ 1.
[[nodiscard]] constexpr SinglePhi<RunTimePhi> from_spectral_radius(double rho_inf) {
  if (!(rho_inf >= 0.0 && rho_inf <= 1.0))
    throw std::invalid_argument("phistep: the spectral radius at infinity must lie in [0, 1]");
  return phi(1.0 / (1.0 + rho_inf));
}

}}  // namespace phistep::PHISTEP_ABI
