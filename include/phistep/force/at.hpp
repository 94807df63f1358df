/// @file
/// Terms of a sum that are taken out of it and enter as kicks: at φ = 0, `springs + at(forward_euler, gravity)`, or called once
/// in k inner steps, `bonds + seldom(8, charges)`.
///
/// Terms at φ = 0 in an implicit scene enter as half kicks before and after the step of the rest (schemes/kicks.hpp):
/// stable while Δt ω < 2 for their own frequency ω, however stiff the rest. The additive mix, (1−φ_j)Ψ_j beside φ_jΨ_j in
/// one update, would be unstable without damping at any Δt.
///
/// With slow terms the stepper's Δt is the outer step, that of the slowest; the terms without `seldom` take inner steps of Δt/k
/// (schemes/kicks.hpp). Terms of several k make several levels: with `bonds + seldom(2, pairs) + seldom(8, charges)` an inner
/// step is Δt/8 long, and the pairs are due at every second one. Nested ones multiply, which is the same sum:
/// `bonds + seldom(2, pairs + seldom(4, charges))`.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/phi.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/force/annotate.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

using ForwardEuler = std::remove_const_t<decltype(forward_euler)>;

/// A term at φ = 0.
template <class F>
struct At : WrappedForce {
  F force;
  explicit constexpr At(F f) : force(std::move(f)) {}
  [[nodiscard]] static constexpr auto around(auto f) { return At<decltype(f)>{std::move(f)}; }
};

template <class T>
inline constexpr bool is_at = is_a<At, T>;

/// A term, and how many inner steps lie between its evaluations.
template <class F>
class Seldom : public WrappedForce {
 public:
  F force;
  /// @throws std::invalid_argument unless k ≥ 1
  constexpr Seldom(int k, F f) : force(std::move(f)), k_{k} {
    if (k < 1)
      throw std::invalid_argument("phistep: seldom(k, term) needs k >= 1 inner steps, not " + std::to_string(k));
  }
  [[nodiscard]] constexpr int k() const { return k_; }
  [[nodiscard]] constexpr auto around(auto f) const { return Seldom<decltype(f)>{k_, std::move(f)}; }

 private:
  int k_;
};

template <class T>
inline constexpr bool is_seldom = is_a<Seldom, T>;

/// Treats a term (a lambda too) or every term of a sum by forward_euler, whatever the stepper's scheme.
template <class Scheme, class F>
[[nodiscard]] constexpr At<F> at(Scheme /*scheme*/, F force) {
  static_assert(!is_seldom<F>, "phistep: seldom(k, term) takes a term without at(scheme, term)");
  static_assert(
      std::is_same_v<Scheme, ForwardEuler>,
      "phistep: at(scheme, term) takes forward_euler: the other terms have the stepper's own scheme (terms at "
      "other phi: not yet)");
  return At<F>{std::move(force)};
}
template <class Scheme, class... T>
[[nodiscard]] constexpr auto at(Scheme scheme, Sum<T...> sum) {
  return map_terms(std::move(sum), [scheme](auto term) { return at(scheme, std::move(term)); });
}

/// Calls a term (a lambda too), or every term of a sum, once in k inner steps.
/// @param k  ≥ 1; every k of a sum has to divide the largest
/// @throws std::invalid_argument unless k ≥ 1
template <class F>
[[nodiscard]] constexpr Seldom<F> seldom(int k, F force) {
  static_assert(!is_at<F>, "phistep: seldom(k, term) takes a term without at(scheme, term)");
  return {k, std::move(force)};
}
template <class F>
[[nodiscard]] constexpr Seldom<F> seldom(int k, Seldom<F> slower) {
  return {k * slower.k(), std::move(slower.force)};
}
template <class... T>
[[nodiscard]] constexpr auto seldom(int k, Sum<T...> sum) {
  return map_terms(std::move(sum), [k](auto term) { return seldom(k, std::move(term)); });
}

/// Whether a term enters as kicks, apart from the others.
template <class T>
inline constexpr bool is_kick = is_at<T> || is_seldom<T>;

/// Whether a stepper of that scheme splits a force into kicks and a rest.
template <class F, class Scheme>
inline constexpr bool is_split = false;
template <class... T, class Scheme>
inline constexpr bool is_split<Sum<T...>, Scheme> = !std::is_same_v<Scheme, ForwardEuler> && (is_kick<T> || ...);

/// The kicks of a sum, or its other terms, as a force of their own.
template <class F>
struct Parts;
template <class... T>
struct Parts<Sum<T...>> {
  /// The places of the kicks in the sum, or of the other terms.
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

  template <bool kicks>
  [[nodiscard]] static constexpr auto tied(auto& all) {
    return [&all]<std::size_t... K>(std::index_sequence<K...>) { return std::tie(std::get<places<kicks>[K]>(all)...); }
    (std::make_index_sequence<places<kicks>.size()>{});
  }
  /// One term as itself, so that it keeps what it offers; several as a sum of references.
  template <bool kicks>
  [[nodiscard]] static constexpr decltype(auto) of(Sum<T...>& sum) {
    constexpr auto at = places<kicks>;
    if constexpr (at.size() == 1) return unwrap(std::get<at[0]>(sum.terms));
    else return std::apply([](auto&... term) { return Sum{std::tuple{std::ref(term)...}}; }, tied<kicks>(sum.terms));
  }
  /// The history that goes with it.
  template <bool kicks, class Memory>
  [[nodiscard]] static constexpr decltype(auto) memory(Memory& all) {
    constexpr auto at = places<kicks>;
    if constexpr (std::is_same_v<std::remove_const_t<Memory>, NoMemory>) return (all);
    else if constexpr (at.size() == 1) return (std::get<at[0]>(all));
    else return tied<kicks>(all);
  }

  using Rest = std::remove_cvref_t<decltype(of<false>(std::declval<Sum<T...>&>()))>;
  using Kicks = std::remove_cvref_t<decltype(of<true>(std::declval<Sum<T...>&>()))>;
};

/// Whether a force has a term seldom(k, term), however deeply nested.
template <class F>
inline constexpr bool has_seldom = [] {
  if constexpr (requires(F & f) { f.force; } && std::is_base_of_v<WrappedForce, F>)
    return is_seldom<F> || has_seldom<decltype(F::force)>;
  else return false;
}();
template <class F>
inline constexpr bool has_seldom<std::reference_wrapper<F>> = has_seldom<std::remove_const_t<F>>;
template <class... T>
inline constexpr bool has_seldom<Sum<T...>> = (has_seldom<T> || ...);

/// Refuses sums in which seldom(k, term) can't be used.
template <class F>
struct SeldomRefusal : Refuses {
  static_assert(!has_seldom<F>,
                "phistep: seldom(k, term) marks a term of the stepper's own sum: write fast + seldom(8, slow)");
};
template <class... T>
struct SeldomRefusal<Sum<T...>> : Refuses {
  static constexpr bool has_any = (is_seldom<T> || ...);
  static_assert((!has_seldom<Unwrapped<T>> && ...),
                "phistep: seldom(k, term) marks a term of the stepper's own sum: write fast + seldom(8, slow)");
  static_assert(
      !has_any || !(is_seldom<T> && ...),
      "phistep: all terms are seldom(k, term), and nothing is left for the inner steps: leave the fastest as it is");
  static_assert(!has_any || ((is_seldom<T> || !is_kick<T>)&&...),
                "phistep: seldom(k, term) and at(forward_euler, term) can't be in one sum");
};

/// How many inner steps a step of this sum has: the largest k. @throws std::invalid_argument where another doesn't divide it
template <class... T>
[[nodiscard]] constexpr int inner_steps(const Sum<T...>& sum) {
  const auto k_of = [](const auto& term) {
    if constexpr (is_seldom<std::remove_cvref_t<decltype(term)>>) return term.k();
    else return 1;
  };
  const auto all = std::apply([&k_of](const T&... term) { return std::array{k_of(term)...}; }, sum.terms);
  const int most = *std::max_element(all.begin(), all.end());
  for (const int k : all)
    if (most % k != 0)
      throw std::invalid_argument("phistep: of seldom(" + std::to_string(k) + ", ...) and seldom(" +
                                  std::to_string(most) + ", ...) in one sum, the first has to divide the second");
  return most;
}

}}  // namespace phistep::PHISTEP_ABI
