/// @file
/// Which schemes are compiled for a problem's types, so that a stepper can choose among them as it goes.
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <variant>

#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/equation/right_hand_side.hpp"
#include "phistep/linear/mass.hpp"
#include "phistep/schemes/choice.hpp"
#include "phistep/schemes/explicit_rk/runge_kutta.hpp"
#include "phistep/schemes/nystrom/nystrom.hpp"
#include "phistep/schemes/radau/radau.hpp"
#include "phistep/schemes/rosenbrock.hpp"
#include "phistep/schemes/tr_bdf2.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/step/phi_stepper.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The scheme of a name, as its type.
template <SuitableScheme scheme>
[[nodiscard]] constexpr auto scheme_named() {
  if constexpr (scheme == SuitableScheme::tsitouras_5) return tsit5;
  else if constexpr (scheme == SuitableScheme::verner_8) return verner87;
  else if constexpr (scheme == SuitableScheme::nystrom_8) return rkn86;
  else if constexpr (scheme == SuitableScheme::nystrom_12) return rkn1210;
  else if constexpr (scheme == SuitableScheme::rodas_4) return rodas4p2;
  else if constexpr (scheme == SuitableScheme::radau_iia) return radau;
  else if constexpr (scheme == SuitableScheme::tr_bdf_2) return tr_bdf2;
  else return rodas5p;
}

/// Names of schemes.
template <SuitableScheme... names>
struct SchemeSet {
  static constexpr std::array all{names...};
  /// Number k of a name; where it is not among them, of what stands in for it: `instead`.
  [[nodiscard]] static constexpr int index_of(SuitableScheme name, int instead) {
    for (std::size_t k = 0; k < all.size(); ++k)
      if (all[k] == name) return static_cast<int>(k);
    return instead;
  }
  template <class S, class F, class MassSpec>
  using Steppers = std::variant<PhiStepper<S, F, std::remove_const_t<decltype(scheme_named<names>())>, MassSpec>...>;
};

/// The checkpoint of whichever stepper is at work.
template <class Steppers>
struct CheckpointOfAny;
template <class... Stepper>
struct CheckpointOfAny<std::variant<Stepper...>> {
  using type = std::variant<typename Stepper::Checkpoint...>;
};

/// Two explicit schemes come first, then the implicit ones. Pairs of particles are solved by conjugate gradients, which serve
/// schemes that resolve.
template <bool is_nystrom, bool is_network>
[[nodiscard]] constexpr auto scheme_set() {
  using enum SuitableScheme;
  if constexpr (is_nystrom && is_network) return SchemeSet<nystrom_8, nystrom_12, tr_bdf_2>{};
  else if constexpr (is_nystrom) return SchemeSet<nystrom_8, nystrom_12, rodas_4, rodas_5p, radau_iia>{};
  else if constexpr (is_network) return SchemeSet<tsitouras_5, verner_8, tr_bdf_2>{};
  else return SchemeSet<tsitouras_5, verner_8, rodas_4, rodas_5p, radau_iia>{};
}

/// Of a state S under a force F with a mass.
template <State S, class F, class MassSpec>
struct SchemesFor {
  using Masses = decltype(bind_masses<S>(std::declval<const MassSpec&>(), std::declval<const PlainState<S>&>()));
  using Rhs = RightHandSide<S, F, Masses>;
  static constexpr bool is_network = Rhs::Traits::structure == Structure::network && !Rhs::has_matrix_mass,
                        is_nystrom = Rhs::drifts && !Rhs::couples_unknowns;
  using Set = decltype(scheme_set<is_nystrom, is_network>());
  using Steppers = typename Set::template Steppers<S, F, MassSpec>;
  static constexpr int explicit_schemes = 2;
};

}  // namespace phistep::inline PHISTEP_ABI
