/// @file
/// Extrapolated schemes, as types: steps of variable order made of many steps of a simple one.
#pragma once

#include <stdexcept>
#include <string>

#include "phistep/core/phi.hpp"
#include "phistep/core/scheme_facts.hpp"
#include "phistep/core/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Richardson's extrapolation of a base scheme: the error's expansion in powers of the substep is eliminated term by term.
/// @tparam Base  the scheme of the substeps
template <class Base>
struct Extrapolated {
  static constexpr SchemeFacts facts{.motion_only = Base::facts.motion_only,
                                     .is_explicit = Base::facts.is_explicit,
                                     .is_symplectic = false,
                                     .is_a_stable = false,
                                     .is_l_stable = false,
                                     .energy = EnergyBalance::rest};
  [[nodiscard]] static std::string name() {
    std::string name = "extrapolated(";
    return name.append(Base::name()).append(1, ')');
  }
  [[no_unique_address]] Base base;
  int columns = 0;  ///< of each step, 0: as many as the error asks for
};

template <class Scheme>
inline constexpr bool is_extrapolated = false;
template <class Base>
inline constexpr bool is_extrapolated<Extrapolated<Base>> = true;

/// Columns that a table has room for, and that a step without error control takes.
inline constexpr int most_columns = 12, usual_columns = 4;

/// Gragg's rule, extrapolated: explicit, for first-order states and motions under any force; order 2j in column j.
///
///     PhiStepper stepper{y, force, extrapolated(forward_euler)};
///
/// It has no printed coefficients, and so serves scalars of any number of digits. In double precision dop853 knows the
/// solution inside its steps and is quicker as a rule; this one wins where many digits are asked of a force that is rough
/// beside Δt (DETEST's B4 to 1e-9: 1.8 times as fast; Lorenz to 1e-6: 1.35), and reported no wrong success there. Motion
/// whose force ignores v has rkn1210.
///
/// @param columns  of every step; left out, the error chooses them (without error control: usual_columns)
/// @throws std::invalid_argument where columns is negative or more than most_columns
template <class Base>
[[nodiscard]] constexpr Extrapolated<Base> extrapolated(Base base, int columns = 0) {
  if (columns < 0 || columns > most_columns)
    throw std::invalid_argument("phistep: extrapolated(scheme, columns) needs 1 <= columns <= 12");
  return {base, columns};
}

/// Linearly implicit Euler, extrapolated: order j in column j. Deprecated, leaves in 0.3: take radau or rodas5p.
///
/// It reports successes that are wrong: near an equilibrium of components of very different size, the table magnifies the
/// roundings of its columns, and the error estimate, a difference of two entries that share them, does not see it. On E5
/// (Hairer & Wanner's test set) the end at t = 1e5 is off by 430 rtol at rtol 1e-10, and at t = 1e11 by more than the
/// solution itself at every rtol from 1e-2 to 1e-11.
[[nodiscard,
  deprecated("phistep: leaves in 0.3, take radau or rodas5p")]] constexpr Extrapolated<SinglePhi<FixedPhi<1>>>
extrapolated(SinglePhi<FixedPhi<1>> base, int columns = 0) {
  return extrapolated<SinglePhi<FixedPhi<1>>>(base, columns);
}

/// Velocity Verlet, extrapolated: order 2j in column j, motion whose force ignores v. Deprecated, leaves in 0.3: take rkn86
/// or rkn1210; beyond long double, extrapolated(forward_euler).
[[nodiscard, deprecated("phistep: leaves in 0.3, take rkn86 or rkn1210")]] constexpr Extrapolated<VelocityVerlet>
extrapolated(VelocityVerlet base, int columns = 0) {
  return extrapolated<VelocityVerlet>(base, columns);
}

}}  // namespace phistep::PHISTEP_ABI
