/// @file
/// The error estimate of an explicit Runge-Kutta pair, of the formulas of order p and p̂,
///
///     e = Δt Σ (b_j − b̂_j) k_j                                                                                  (1)
///
/// (Hairer, Nørsett & Wanner, Solving ODEs I, eq. II.4.6). That of a motion's r follows from the k, too: its slopes are the
/// velocities of the stages (eq. II.14.5).
#pragma once

#include <cstddef>
#include <iterator>
#include <type_traits>
#include <utility>

#include "phistep/core/version.hpp"
#include "phistep/schemes/explicit_stages.hpp"
#include "phistep/state/blocks.hpp"
#include "phistep/state/unknowns.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Weights of the k_j, as types, so that sums are unrolled, and zeros are left out.
namespace runge_kutta {
/// b_j − b̂_j
template <class Tableau>
struct Error {
  static constexpr std::size_t count = std::size(Tableau::e);
  static constexpr long double at(std::size_t j) { return Tableau::e[j]; }
};
/// The weights of the k_l in a sum over a motion's velocities, with weights w_j: Σ_j w_j a_jl.
template <class Tableau, class Weights>
struct OfPositions {
  static constexpr std::size_t count = Weights::count == 0 ? 0 : Weights::count - 1;
  static constexpr long double at(std::size_t l) {
    long double sum = 0;
    for (std::size_t j = l + 1; j < Weights::count; ++j) sum += Weights::at(j) * Tableau::a[j][l];
    return sum;
  }
};
}  // namespace runge_kutta

template <class Tableau, State S>
struct RungeKuttaEstimate {
  static constexpr bool needs_end = std::size(Tableau::e) > Tableau::end;  ///< … k⁺

  [[gnu::always_inline]] static void tell(const ExplicitStages<S, Tableau::stages>& k, ScalarOf<S> dt, auto& trace) {
    using Error = runge_kutta::Error<Tableau>;
    for_each_block([&](auto block, auto& e) { k.template put<Error, block>(dt, e); }, Blocks<S>::solved(trace.error));
    if constexpr (Blocks<S>::drifts)
      k.template put<runge_kutta::OfPositions<Tableau, Error>>(dt * dt, position_of<S>(trace.error));
    trace.has_error = true;
  }
};

}  // namespace phistep::inline PHISTEP_ABI
