/// @file
/// What the type of a scheme says of it: one constexpr value, `Scheme::facts`, without defaults, so that a scheme, or a
/// scheme around a scheme, that forgets one doesn't compile. What depends on a value (the order of radau(5), φ given at
/// run time) is a member function.
#pragma once

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
  Fact<bool> is_l_stable;      ///< … and R(∞) = 0
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
/// An explicit scheme for any state under any force, and what is left to say of it.
struct ExplicitOfAny {
  Fact<EnergyBalance> energy;
  constexpr operator SchemeFacts() const {  // NOLINT: facts = ExplicitOfAny{…}
    return {.motion_only = false,
            .is_explicit = true,
            .is_symplectic = false,
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

}}  // namespace phistep::PHISTEP_ABI
