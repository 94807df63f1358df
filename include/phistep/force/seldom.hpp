/// @file
/// A slow term of a sum, evaluated once in k inner steps: `bonds + seldom(8, charges)`.
///
/// The stepper's Δt is then the outer step, that of the slowest term; the terms without `seldom` take inner steps of Δt/k
/// (schemes/respa.hpp). Terms of several k make several levels: with `bonds + seldom(2, pairs) + seldom(8, charges)` an inner
/// step is Δt/8 long, and the pairs are due at every second one. Nested ones multiply, which is the same sum:
/// `bonds + seldom(2, pairs + seldom(4, charges))`.
#pragma once

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/at.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

 private:
  int k_;
};

template <class T>
inline constexpr bool is_seldom = false;
template <class F>
inline constexpr bool is_seldom<Seldom<F>> = true;

/// The terms are taken out of the sum that the inner steps see, as those of at(forward_euler, term) are.
template <class F>
inline constexpr bool is_kick<Seldom<F>> = true;

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
  return std::apply([k](auto&&... term) { return make_sum(std::tuple{seldom(k, std::move(term))...}); },
                    std::move(sum.terms));
}
template <class Scheme, class F>
[[nodiscard]] constexpr At<Scheme, F> at(Scheme /*scheme*/, Seldom<F> term) {
  static_assert(!sizeof(F), "phistep: seldom(k, term) takes a term without at(scheme, term)");
  return At<Scheme, F>{std::move(term.force)};
}
template <template <class> class Annotation, class F>
[[nodiscard]] constexpr auto annotate(Seldom<F> term) {
  auto annotated = annotate<Annotation>(std::move(term.force));
  return Seldom<decltype(annotated)>{term.k(), std::move(annotated)};
}

/// Whether a force, however deep, has a term that is called seldom.
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

/// What a sum with slow terms has to be.
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
  int most = 1;
  const auto for_each_k = [&sum](auto&& f) {
    const auto look = [&f](const auto& term) {
      if constexpr (is_seldom<std::remove_cvref_t<decltype(term)>>) f(term.k());
    };
    std::apply([&look](const auto&... term) { (look(term), ...); }, sum.terms);
  };
  for_each_k([&most](int k) { most = std::max(most, k); });
  for_each_k([most](int k) {
    if (most % k != 0)
      throw std::invalid_argument("phistep: of seldom(" + std::to_string(k) + ", ...) and seldom(" +
                                  std::to_string(most) + ", ...) in one sum, the first has to divide the second");
  });
  return most;
}

}}  // namespace phistep::PHISTEP_ABI
