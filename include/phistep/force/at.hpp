/// @file
/// A term of a sum with a φ of its own: `springs + at(forward_euler, gravity)`.
///
/// Terms at φ = 0 in an implicit scene enter as half kicks before and after the step of the rest (schemes/splitting.hpp):
/// stable while Δt ω < 2 for their own frequency ω, however stiff the rest. The additive mix, (1−φ_j)Ψ_j beside φ_jΨ_j in
/// one update, would be unstable without damping at any Δt.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/phi.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/annotate.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A term and the scheme it is treated by.
template <class Scheme, class F>
struct At : WrappedForce {
  F force;
  explicit constexpr At(F f) : force(std::move(f)) {}
};

/// Gives a term (a lambda too) or every term of a sum a scheme of its own: forward_euler, or the stepper's.
template <class Scheme, class F>
[[nodiscard]] constexpr At<Scheme, F> at(Scheme /*scheme*/, F force) {
  static_assert(std::is_empty_v<Scheme>, "phistep: at(scheme, term) takes a scheme known at compile time");
  return At<Scheme, F>{std::move(force)};
}
template <class Scheme, class... T>
[[nodiscard]] constexpr auto at(Scheme scheme, Sum<T...> sum) {
  return std::apply([scheme](auto&&... term) { return make_sum(std::tuple{at(scheme, std::move(term))...}); },
                    std::move(sum.terms));
}

template <template <class> class Annotation, class Scheme, class F>
[[nodiscard]] constexpr auto annotate(At<Scheme, F> term) {
  auto annotated = annotate<Annotation>(std::move(term.force));
  return At<Scheme, decltype(annotated)>{std::move(annotated)};
}

using ForwardEuler = std::remove_const_t<decltype(forward_euler)>;

template <class T>
inline constexpr bool is_at = false;
template <class Scheme, class F>
inline constexpr bool is_at<At<Scheme, F>> = true;

/// Whether a term enters as kicks, apart from the others: here, and where it is called seldom (seldom.hpp).
template <class T>
inline constexpr bool is_kick = false;
template <class F>
inline constexpr bool is_kick<At<ForwardEuler, F>> = true;

/// Whether a stepper of that scheme splits a force into kicks and a rest.
template <class F, class Scheme>
inline constexpr bool is_split = false;
template <class... T, class Scheme>
inline constexpr bool is_split<Sum<T...>, Scheme> = !std::is_same_v<Scheme, ForwardEuler> && (is_kick<T> || ...);

/// Whether a stepper of that scheme can treat a term, or all of a sum's, as asked for.
template <class T, class Scheme>
inline constexpr bool suits = true;
template <class Scheme, class F, class Own>
inline constexpr bool suits<At<Scheme, F>, Own> = std::is_same_v<Scheme, Own> || is_kick<At<Scheme, F>>;
template <class... T, class Scheme>
inline constexpr bool suits<Sum<T...>, Scheme> = (suits<T, Scheme> && ...);

/// The kicks of a sum, or its other terms, as a force of their own.
template <class F>
struct Parts;
template <class... T>
struct Parts<Sum<T...>> {
  /// Where they stand in the sum.
  template <bool kicks>
  static constexpr auto places = [] {
    std::array<std::size_t, ((is_kick<T> == kicks ? 1 : 0) + ... + 0)> found{};
    std::size_t n = 0, k = 0;
    const auto look = [&](bool wanted) {
      if (wanted) found[n++] = k;
      ++k;
    };
    (look(is_kick<T> == kicks), ...);
    return found;
  }();

  /// One term as itself, so that it keeps what it offers; several as a sum of references.
  template <bool kicks>
  [[nodiscard]] static constexpr decltype(auto) of(Sum<T...>& sum) {
    constexpr auto at = places<kicks>;
    if constexpr (at.size() == 1) {
      return unwrap(std::get<at[0]>(sum.terms));
    } else {
      return [&sum]<std::size_t... K>(std::index_sequence<K...>) {
        return make_sum(std::tuple{std::ref(std::get<places<kicks>[K]>(sum.terms))...});
      }
      (std::make_index_sequence<at.size()>{});
    }
  }
  /// The history that goes with it.
  template <bool kicks, class Memory>
  [[nodiscard]] static constexpr decltype(auto) memory(Memory& all) {
    constexpr auto at = places<kicks>;
    if constexpr (std::is_same_v<std::remove_const_t<Memory>, NoMemory>) {
      return (all);
    } else if constexpr (at.size() == 1) {
      return (std::get<at[0]>(all));
    } else {
      return [&all]<std::size_t... K>(std::index_sequence<K...>) {
        return std::tie(std::get<places<kicks>[K]>(all)...);
      }
      (std::make_index_sequence<at.size()>{});
    }
  }

  using Rest = std::remove_cvref_t<decltype(of<false>(std::declval<Sum<T...>&>()))>;
  using Kicks = std::remove_cvref_t<decltype(of<true>(std::declval<Sum<T...>&>()))>;
};

}}  // namespace phistep::PHISTEP_ABI
