/// @file
/// A number and its derivative by one variable: (x, x'), forward differentiation of short formulas such as pair laws.
/// Not for whole forces: autodiff.hpp does those.
#pragma once

#include <type_traits>

#include "phistep/base/numbers/pack_math.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// @tparam T  a number or a Pack
template <class T>
struct Dual {
  T x;         ///< value
  T slope{0};  ///< derivative

  template <class Number>
    requires std::is_arithmetic_v<Number>
  constexpr Dual(Number constant) : x(static_cast<typename ScalarIn<T>::type>(constant)) {}
  constexpr Dual(T value) requires(!std::is_arithmetic_v<T>) : x(value) {}
  constexpr Dual(T value, T derivative) : x(value), slope(derivative) {}

  friend Dual operator-(Dual a) { return {-a.x, -a.slope}; }
  friend Dual operator+(Dual a, Dual b) { return {a.x + b.x, a.slope + b.slope}; }
  friend Dual operator-(Dual a, Dual b) { return {a.x - b.x, a.slope - b.slope}; }
  friend Dual operator*(Dual a, Dual b) { return {a.x * b.x, a.slope * b.x + a.x * b.slope}; }
  friend Dual operator/(Dual a, Dual b) {
    const T q = a.x / b.x;
    return {q, (a.slope - q * b.slope) / b.x};
  }
  Dual& operator+=(Dual b) { return *this = *this + b; }
  Dual& operator-=(Dual b) { return *this = *this - b; }
  Dual& operator*=(Dual b) { return *this = *this * b; }
  Dual& operator/=(Dual b) { return *this = *this / b; }
  friend auto operator<(Dual a, Dual b) { return a.x < b.x; }
  friend auto operator>(Dual a, Dual b) { return a.x > b.x; }
  friend auto operator<=(Dual a, Dual b) { return a.x <= b.x; }
  friend auto operator>=(Dual a, Dual b) { return a.x >= b.x; }
};

template <class T>
[[nodiscard]] Dual<T> select(auto condition, Dual<T> a, std::type_identity_t<Dual<T>> b) {
  return {select(condition, a.x, b.x), select(condition, a.slope, b.slope)};
}
template <class T>
[[nodiscard]] Dual<T> sqrt(Dual<T> a) {
  const T root = sqrt(a.x);
  return {root, a.slope / (2 * root)};
}
template <class T>
[[nodiscard]] Dual<T> reciprocal(Dual<T> a) {
  const T y = reciprocal(a.x);
  return {y, -(a.slope * y * y)};
}
template <class T>
[[nodiscard]] Dual<T> rsqrt(Dual<T> a) {
  const T y = rsqrt(a.x);
  return {y, a.slope * y * y * y / -2};
}
template <class T>
[[nodiscard]] Dual<T> rsqrt3(Dual<T> a) {
  const T y = rsqrt3(a.x);
  return {y, -3 * a.slope * y / (2 * a.x)};
}
template <class T>
[[nodiscard]] Dual<T> exp(Dual<T> a) {
  const T y = exp(a.x);
  return {y, a.slope * y};
}
template <class T>
[[nodiscard]] Dual<T> pow(Dual<T> a, double n) {
  const T y = pow(a.x, static_cast<typename ScalarIn<T>::type>(n));
  return {y, static_cast<typename ScalarIn<T>::type>(n) * a.slope * y / a.x};
}
template <class T>
[[nodiscard]] Dual<T> fma(Dual<T> a, std::type_identity_t<Dual<T>> b, std::type_identity_t<Dual<T>> c) {
  return a * b + c;
}
template <class T>
[[nodiscard]] Dual<T> min(Dual<T> a, std::type_identity_t<Dual<T>> b) {
  return select(b < a, b, a);
}
template <class T>
[[nodiscard]] Dual<T> max(Dual<T> a, std::type_identity_t<Dual<T>> b) {
  return select(a < b, b, a);
}

}}  // namespace phistep::PHISTEP_ABI
