/// @file
/// What the type of a scheme says of it: one constexpr value, `Scheme::facts`, without defaults, so that a scheme, or a
/// scheme around a scheme, that forgets one doesn't compile. What depends on a value (the order of radau(5), φ given at
/// run time) is a member function.
#pragma once

#include <array>
#include <type_traits>
#include <utility>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A fact: has no default.
template <class T>
struct Fact {
  T value;
  constexpr Fact(T x) : value{x} {}  // NOLINT: .is_explicit = true
  constexpr operator T() const { return value; }
};

/// Which force and which velocity a scheme's energy balance has (study/energy/energy_ledger.hpp).
enum class EnergyBalance {
  rest,      ///< none is known: the scheme's account is what the others leave
  endpoint,  ///< both ends, weighted by φ
  stage,     ///< the stage
  verlet     ///< velocity Verlet's
};

/// What the type of a scheme says of it.
struct SchemeFacts {
  Fact<bool> motion_only;      ///< treats r and v differently: it takes no first-order state
  Fact<bool> is_explicit;      ///< solves nothing where the force ignores v
  Fact<bool> is_symplectic;    ///< where the force ignores v
  Fact<bool> is_a_stable;      ///< |R(z)| ≤ 1 for Re z ≤ 0
  Fact<bool> is_l_stable;      ///< A-stable, and R(∞) = 0
  Fact<EnergyBalance> energy;  ///< which formulas the energy ledger has for it
};

/// An explicit scheme of motion, and what is left to say of it.
struct ExplicitMotion {
  Fact<bool> is_symplectic;
  Fact<EnergyBalance> energy;
  constexpr operator SchemeFacts() const {  // NOLINT: facts = ExplicitMotion{…}
    return {.motion_only = true,
            .is_explicit = true,
            .is_symplectic = is_symplectic,
            .is_a_stable = false,
            .is_l_stable = false,
            .energy = energy};
  }
};
/// An implicit scheme for any state, A-stable and not symplectic.
struct AStable {
  Fact<bool> is_l_stable;
  Fact<EnergyBalance> energy;
  constexpr operator SchemeFacts() const {  // NOLINT: facts = AStable{…}
    return {.motion_only = false,
            .is_explicit = false,
            .is_symplectic = false,
            .is_a_stable = true,
            .is_l_stable = is_l_stable,
            .energy = energy};
  }
};

// What the type of a stepper says of it: `Stepper::facts`, without defaults, so that a stepper around a stepper says each
// for itself, or doesn't compile. One of a user's own need not have any.

struct StepperFacts {
  Fact<bool> traces;           ///< it has `attempt`, which can tell how large a step's error is
  Fact<bool> interpolates;     ///< it knows the solution inside the step just accepted better than its ends tell
  Fact<bool> is_sure_inside;   ///< its interpolant is as good as its estimated error: no check
  Fact<bool> solves_nothing;   ///< stability keeps Δt within what slopes at both ends can tell
  Fact<bool> reads_weights;    ///< its steps read trace.weight, to solve to the tolerance or to estimate errors
  Fact<bool> refactorizes;     ///< each step makes its matrix anew, so that keeping Δt spares nothing
  Fact<bool> is_affine;        ///< one factorization serves all steps of one Δt
  Fact<bool> takes_several;    ///< it has `steps`, which does several steps of one length in one call
  Fact<bool> has_inner_steps;  ///< whose number ties its steps to one length
  Fact<std::array<double, 2>> doubtful_at;  ///< where in a step, 0 < x < 1, its interpolant is worst
};

/// Seven tenths of the largest error and more: of Hermite's interpolant, which goes as x²(1−x)², and as x(1−x)(1−2x) where
/// slopes are wrong; of collocation at Radau's 3, 5 or 7 nodes, which goes as ∫Π(x−c_i), and as xΠ(x−c_i) where it is stiff.
inline constexpr std::array<double, 2> usually_doubtful{0.35, 0.68};

/// The facts of a stepper; of one that says nothing, what is safe.
template <class Stepper>
inline constexpr bool hides_inner_steps = false;
template <class Stepper>
inline constexpr StepperFacts facts_of{.traces = false,
                                       .interpolates = false,
                                       .is_sure_inside = false,
                                       .solves_nothing = false,
                                       .reads_weights = true,
                                       .refactorizes = false,
                                       .is_affine = false,
                                       .takes_several = false,
                                       .has_inner_steps = hides_inner_steps<Stepper>,
                                       .doubtful_at = usually_doubtful};
template <class Stepper>
  requires requires { Stepper::facts; }
inline constexpr StepperFacts facts_of<Stepper> = Stepper::facts;
template <class Stepper>
  requires requires(Stepper& outer) { outer.stepper(); }
inline constexpr bool hides_inner_steps<Stepper> =
    facts_of<std::remove_cvref_t<decltype(std::declval<Stepper&>().stepper())>>.has_inner_steps;

/// What runs and studies read of a PhiStepper beside its public face.
struct StepperInternals {
  /// The kernel, which holds the right-hand side and the solver.
  [[nodiscard]] static auto kernel(auto& stepper) -> decltype((stepper.kernel_)) { return stepper.kernel_; }
  [[nodiscard]] static auto scheme(auto& stepper) -> decltype((stepper.scheme_)) { return stepper.scheme_; }
  /// What mass(…) or capacity(…) returned.
  [[nodiscard]] static auto mass(auto& stepper) -> decltype((stepper.mass_)) { return stepper.mass_; }
  /// What runs under a tolerance without atol leave for the next.
  [[nodiscard]] static auto kept_sizes(auto& stepper) -> decltype((stepper.sizes_)) { return stepper.sizes_; }
  /// f(stepper); of one that holds several, f(the one at work).
  template <class Stepper>
  static decltype(auto) chosen(Stepper& stepper, auto&& f) {
    if constexpr (requires { stepper.steppers_; }) return stepper.visit(stepper, f);
    else return f(stepper);
  }
  /// f(the PhiStepper that does the steps), also of a stepper around it; of one of a user's own, nothing.
  template <class Stepper>
  static decltype(auto) at_work(Stepper& stepper, auto&& f) {
    if constexpr (
        requires { kernel(stepper); } || requires { stepper.steppers_; })
      return chosen(stepper, f);
    else if constexpr (requires { stepper.stepper(); }) return at_work(stepper.stepper(), f);
    else return;
  }
  static auto forget_known(auto& stepper) -> decltype(stepper.forget_known()) { stepper.forget_known(); }
};

}}  // namespace phistep::PHISTEP_ABI
