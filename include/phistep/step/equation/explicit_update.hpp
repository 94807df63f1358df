/// @file
/// The coefficients by which a step weighs Ψ and v, and the explicit updates y + γ M⁻¹Ψ: of a component, as kernels for the
/// passes of base/numbers/update.hpp, and of a state:
///
///     kick         v⁺ = v + (h/m) Ψ                                                                             (1)
///     kick, drift  v⁺ = v + (h/m) Ψ,   r⁺ = r + (before v + after v⁺)                                           (2)
#pragma once

#include <cmath>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/numbers/update.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The coefficients of a resolve: γ on the force and γ on the drift. [time]
template <class Scalar>
struct Gamma {
  Scalar force;  ///< γ_f, on Ψ
  Scalar drift;  ///< γ_d, on a motion's v
  friend bool operator==(const Gamma&, const Gamma&) = default;
};

/// By what corrections with factors made for γ_p are multiplied so that they serve γ: 2/(1 + γ/γ_p), with (γ/γ_p)² where W has
/// γ_f γ_d alone (A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363, sect. 2.1). 0: they don't serve, being
/// further apart than `within`, or other ones of force and drift.
template <class Scalar>
[[nodiscard]] Scalar correction_scale(const Gamma<Scalar>& gamma, const Gamma<Scalar>& made_for, Scalar within,
                                      bool is_square) {
  const Scalar ratio = gamma.force / made_for.force;
  const bool is_similar = gamma.drift * made_for.force == gamma.force * made_for.drift;
  if (!(std::abs(ratio - 1) <= within) || !is_similar) return Scalar{0};
  return 2 / (1 + (is_square ? ratio * ratio : ratio));
}

/// A coefficient that is 0 for every Δt: its term is left out. 0·v⁺ would make r⁺ wait for v⁺.
using Zero = std::integral_constant<int, 0>;
/// h, or Zero where that is known when compiling
template <bool is_zero, class Scalar>
[[nodiscard]] constexpr auto unless(Scalar h) {
  if constexpr (is_zero) return Zero{};
  else return h;
}

/// Coefficients of out = y + γ M⁻¹Ψ, and for motion r⁺ = r + before·v + after·v⁺. [time]
template <class Scalar, class Before = Scalar, class After = Scalar>
struct Advance {
  Scalar kick;    ///< γ on M⁻¹Ψ
  Before before;  ///< on the velocity that the step starts from
  After after;    ///< on the velocity just computed
  operator Advance<Scalar>() const requires(!std::is_same_v<Advance, Advance<Scalar>>) {
    return {kick, static_cast<Scalar>(before), static_cast<Scalar>(after)};
  }
};
template <class Scalar, class Before, class After>
Advance(Scalar, Before, After) -> Advance<Scalar, Before, After>;

/// (1)
/// @tparam Factor  i ↦ h/m_i
template <class Scalar, class Factor>
struct Kick {
  Input<Scalar> v, psi;
  Factor factor;
  Kick(Input<Scalar> v0, Input<Scalar> f, Factor scale) : v{v0}, psi{f}, factor{scale} {}
  [[gnu::always_inline]] inline void operator()(auto i, auto& v1) const { v1 = v[i] + factor(i) * psi[i]; }
};

/// (2)
template <class Scalar, class Factor, class Before, class After>
struct KickAndDrift {
  Input<Scalar> r, v, psi;
  Factor factor;
  [[no_unique_address]] Before before;  ///< [time]
  [[no_unique_address]] After after;    ///< [time]
  KickAndDrift(Input<Scalar> r0, Input<Scalar> v0, Input<Scalar> f, Factor scale, Before drift_before,
               After drift_after)
      : r{r0}, v{v0}, psi{f}, factor{scale}, before{drift_before}, after{drift_after} {}
  [[gnu::always_inline]] inline void operator()(auto i, auto& v1, auto& r1) const {
    v1 = v[i] + factor(i) * psi[i];
    if constexpr (std::is_same_v<After, Zero>) r1 = r[i] + before * v[i];
    else if constexpr (std::is_same_v<Before, Zero>) r1 = r[i] + after * v1;
    else r1 = r[i] + (before * v[i] + after * v1);
  }
};

/// put(kernel, block of out…) for every pass that the update takes, whatever has the blocks of `out`: a state or a view of one.
/// The kernel is (1) or, for the velocities of a motion, (2). Not for matrix masses.
template <State S, bool with_drift = Blocks<S>::drifts>
[[gnu::always_inline]] inline void for_each_update(const PlainState<S>& y, const auto& by, const auto& psi,
                                                   const auto& masses, auto&& put, auto& out) {
  for_each_block(
      [&](auto k, auto& to, const auto& from, const auto& rate, const auto& mass) PHISTEP_DETAIL_INLINED {
        const auto factor = mass.h_over_mass(by.kick);
        if constexpr (with_drift && k == 0) {
          const ScalarOf<S>* const r = std::get<0>(Blocks<S>::all(y)).data();
          const KickAndDrift kernel{Input{r}, Input{from.data()}, Input{rate.data()}, factor, by.before, by.after};
          put(kernel, to, std::get<0>(Blocks<S>::all(out)));
        } else {
          const Kick kernel{Input{from.data()}, Input{rate.data()}, factor};
          put(kernel, to);
        }
      },
      Blocks<S>::solved(out), Blocks<S>::solved(y), psi, masses);
}

/// out = y + γ M⁻¹Ψ without matrices for masses, all blocks and the drift in one pass each. False: something isn't finite.
template <State S, bool with_drift>
[[nodiscard, gnu::always_inline]] inline bool advance_components(PlainState<S>& out, const PlainState<S>& y,
                                                                 const auto& by, const auto& psi, const auto& masses) {
  bool finite = true;
  for_each_update<S, with_drift>(
      y, by, psi, masses,
      [&](const auto& kernel, auto& to, auto&... position) PHISTEP_DETAIL_INLINED {
        constexpr int size = std::remove_cvref_t<decltype(to)>::SizeAtCompileTime;
        if constexpr (few_numbers(size))
          finite = update_unrolled<size>(kernel, to.data(), position.data()...) && finite;
        else if (&out == &y) finite = update_in_place(to.size(), kernel, to.data(), position.data()...) && finite;
        else finite = update(to.size(), kernel, to.data(), position.data()...) && finite;
      },
      out);
  return finite;
}
/// The same for some particles; `out` holds the others already.
template <State S, bool with_drift = Blocks<S>::drifts>
[[nodiscard]] bool advance_particles(PlainState<S>& out, const PlainState<S>& y, const Advance<ScalarOf<S>>& by,
                                     const auto& psi, const auto& masses, const std::vector<std::int32_t>& particles) {
  using Scalar = ScalarOf<S>;
  FiniteWitness<Scalar> witness;
  for_each_update<S, with_drift>(
      y, by, psi, masses,
      [&](const auto& kernel, auto& to, auto&... position) {
        for (const Index i : particles)
          for (Index k = to.rows() * i; k < to.rows() * (i + 1); ++k)
            [&](auto... result) {  // beside: `out` may be y
              kernel(k, result...);
              std::tie(to.data()[k], position.data()[k]...) = std::tie(result...);
              (witness.see(result), ...);
            }(Scalar{}, (static_cast<void>(position), Scalar{})...);
      },
      out);
  return witness.all_finite();
}

/// out = y + γ M⁻¹Ψ of fields, unchecked.
template <FieldState S, bool with_drift = Blocks<S>::drifts>
void advance_fields(PlainState<S>& out, const PlainState<S>& y, const auto& by, const auto& psi, const auto& masses) {
  for_each_block(
      [&](auto k, auto& to, const auto& from, const auto& rate, const auto& mass) {
        const auto factor = field_factor(mass, by.kick);
        if constexpr (with_drift && k == 0)  // r⁺ first, for `out` may be y
          std::get<0>(Blocks<S>::all(out)) =
              std::get<0>(Blocks<S>::all(y)) + (by.before + by.after) * from + (by.after * factor) * rate;
        to = from + factor * rate;
      },
      Blocks<S>::solved(out), Blocks<S>::solved(y), psi, masses);
}

/// out = y + γ M⁻¹Ψ, for motion with the drift; `out` may be y. False: something isn't finite.
/// @param scratch  for M⁻¹Ψ where a mass is a matrix
template <State S, bool with_drift = Blocks<S>::drifts>
[[nodiscard, gnu::always_inline]] inline bool advance_blocks(PlainState<S>& out, const PlainState<S>& y, const auto& by,
                                                             const auto& psi, RateOf<S>& scratch, const auto& masses) {
  using Rate = RateOf<S>;
  if constexpr (FieldState<PlainState<S>>) {
    advance_fields<S, with_drift>(out, y, by, psi, masses);
    return all_finite(Blocks<S>::all(out));
  } else if constexpr (MassFacts<std::remove_cvref_t<decltype(masses)>, ScalarOf<S>>::has_matrix) {
    for_each_block(
        [](auto, auto& to, const auto& from, const auto& mass) {
          if (&to != &from) to = from;
          // What isn't finite shows in the result. M⁻¹ would spread it over all components, and hide which one had it.
          if constexpr (std::remove_cvref_t<decltype(mass)>::is_matrix) static_cast<void>(divide_by_mass(to, mass));
        },
        Rate::blocks(scratch), psi, masses);
    return advance_components<S, with_drift>(out, y, by, Rate::blocks(std::as_const(scratch)), masses);
  } else {
    return advance_components<S, with_drift>(out, y, by, psi, masses);
  }
}
/// y.solved += γ M⁻¹Ψ.
template <State S>
[[nodiscard, gnu::always_inline]] inline bool kick_blocks(PlainState<S>& y, ScalarOf<S> gamma, const auto& psi,
                                                          RateOf<S>& scratch, const auto& masses) {
  return advance_blocks<S, false>(y, y, Advance{gamma, Zero{}, Zero{}}, psi, scratch, masses);
}
/// r += h v.
template <State S>
void drift_blocks(PlainState<S>& y, ScalarOf<S> h) {
  if constexpr (Blocks<S>::drifts) std::get<0>(Blocks<S>::all(y)) += h * std::get<1>(Blocks<S>::all(y));
}

}}  // namespace phistep::PHISTEP_ABI
