/// @file
/// A sum of force terms is a force, whose needs are the union of its terms' needs.
#pragma once

#include <functional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/version.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Base of everything that `+` adds up.
struct ForceTerm {};
/// Base of terms that are nothing but their member `force`; around(f) is such a term of another one.
struct WrappedForce : ForceTerm {};

template <class T>
concept Addable = std::is_base_of_v<ForceTerm, T>;

/// Any force as a term, so that two lambdas add.
template <class F>
struct Term : WrappedForce {
  F force;
  explicit constexpr Term(F f) : force(std::move(f)) {}
  [[nodiscard]] static constexpr auto around(auto f) { return Term<decltype(f)>{std::move(f)}; }
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

/// Whether T is made by a class template.
template <template <class...> class Template, class T>
inline constexpr bool is_a = false;
template <template <class...> class Template, class... Arguments>
inline constexpr bool is_a<Template, Template<Arguments...>> = true;
template <class T>
inline constexpr bool is_sum = is_a<Sum, T>;

template <class T>
[[nodiscard]] constexpr auto as_terms(T term) {
  if constexpr (is_sum<T>) return std::move(term.terms);
  else return std::tuple<T>{std::move(term)};
}
/// The sum of f(term) for every term of a sum.
template <class... T>
[[nodiscard]] constexpr auto map_terms(Sum<T...> sum, auto&& f) {
  return std::apply([&f](T&... term) { return Sum{std::tuple{f(std::move(term))...}}; }, sum.terms);
}

/// Sums stay flat: (a + b) + c has three terms.
template <Addable A, Addable B>
[[nodiscard]] constexpr auto operator+(A a, B b) {
  return Sum{std::tuple_cat(as_terms(std::move(a)), as_terms(std::move(b)))};
}

/// Refuses term + lambda, and says what to write instead.
template <class A, class B>
  requires((Addable<A> && std::is_class_v<B> && !Addable<B>) || (Addable<B> && std::is_class_v<A> && !Addable<A>))
constexpr int operator+(A, B) {
  static_assert(
      Addable<A> && Addable<B>,
      "phistep: a lambda, or any other force without a + of its own, is added as term(f): term(f) + Gravity{...}");
  return 0;
}

/// The force behind terms and std::reference_wrappers, however they nest.
template <class F>
[[nodiscard]] constexpr auto& unwrap(F& force) {
  // No overloads: with a user's type in a std::reference_wrapper, the recursion would not find those declared further down.
  if constexpr (is_a<std::reference_wrapper, std::remove_const_t<F>>) return unwrap(force.get());
  else if constexpr (std::is_base_of_v<WrappedForce, F>) return unwrap(force.force);
  else return force;
}
/// f(term) for every term of a force; for itself where it is no sum.
template <class F>
constexpr void for_each_summand(F& force, auto&& f) {
  if constexpr (is_sum<std::remove_const_t<F>>)
    std::apply([&f](auto&... term) { (for_each_summand(unwrap(term), f), ...); }, force.terms);
  else f(force);
}
template <class F>
using Unwrapped = std::remove_cvref_t<decltype(unwrap(std::declval<F&>()))>;
/// The force as a stepper keeps it, not const: a reference to it, or of a const force a copy, if it can be copied.
template <class F>
[[nodiscard]] constexpr decltype(auto) changeable(F& force) {
  if constexpr (std::is_const_v<F> && std::is_copy_constructible_v<F>) return std::remove_const_t<F>(force);
  else return (force);
}

}}  // namespace phistep::PHISTEP_ABI
