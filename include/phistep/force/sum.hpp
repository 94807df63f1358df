/// @file
/// A sum of force terms is a force, whose needs are the union of its terms' needs.
#pragma once

#include <functional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Base of everything that `+` adds up.
struct ForceTerm {};

template <class T>
concept Addable = std::is_base_of_v<ForceTerm, T>;

/// Any force as a term, so that two lambdas add.
template <class F>
struct Term : ForceTerm {
  F force;
  explicit constexpr Term(F f) : force(std::move(f)) {}
};

/// Makes a force (a lambda, say) addable: `term(f) + term(g) + Gravity{…}`.
template <class F>
[[nodiscard]] constexpr Term<F> term(F force) {
  return Term<F>{std::move(force)};
}

template <class... Terms>
struct Sum : ForceTerm {
  std::tuple<Terms...> terms;
  explicit constexpr Sum(std::tuple<Terms...> t) : terms(std::move(t)) {}
};

template <class T>
[[nodiscard]] constexpr std::tuple<T> as_terms(T term) {
  return std::tuple<T>{std::move(term)};
}
template <class... T>
[[nodiscard]] constexpr std::tuple<T...> as_terms(Sum<T...> sum) {
  return std::move(sum.terms);
}
template <class... T>
[[nodiscard]] constexpr Sum<T...> make_sum(std::tuple<T...> terms) {
  return Sum<T...>{std::move(terms)};
}

/// Sums stay flat: (a + b) + c has three terms.
template <Addable A, Addable B>
[[nodiscard]] constexpr auto operator+(A a, B b) {
  return make_sum(std::tuple_cat(as_terms(std::move(a)), as_terms(std::move(b))));
}

template <class T>
inline constexpr bool is_sum = false;
template <class... T>
inline constexpr bool is_sum<Sum<T...>> = true;

/// The force behind a Term or a std::reference_wrapper.
template <class F>
[[nodiscard]] constexpr auto& unwrap(F& force) {
  return force;
}
template <class F>
[[nodiscard]] constexpr auto& unwrap(Term<F>& term) {
  return unwrap(term.force);
}
template <class F>
[[nodiscard]] constexpr auto& unwrap(const Term<F>& term) {
  return unwrap(term.force);
}
template <class F>
[[nodiscard]] constexpr auto& unwrap(std::reference_wrapper<F>& reference) {
  return unwrap(reference.get());
}
template <class F>
[[nodiscard]] constexpr auto& unwrap(const std::reference_wrapper<F>& reference) {
  return unwrap(reference.get());
}
template <class F>
using Unwrapped = std::remove_cvref_t<decltype(unwrap(std::declval<F&>()))>;

}  // namespace phistep::inline PHISTEP_ABI
