#pragma once

// A number beside a bound of what rounding does to it, in units of u = 2⁻⁵³ and to first order: the bounds of the atlas are
// worked out cell by cell, operation by operation (running error analysis; N. J. Higham, Accuracy and Stability of
// Numerical Algorithms, 2nd ed., sect. 3.3), and not fitted to what was measured.

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

namespace stability {

using Real = long double;
using Complex = std::complex<Real>;

inline constexpr Real unit_roundoff = 0x1p-53L;

/// What one product costs: of two numbers u, of a 2×2 matrix [[a, −b], [b, a]] with a vector 2√2 u (sect. 3.6).
template <class T>
inline constexpr Real product_cost = 1;
template <>
inline constexpr Real product_cost<Complex> = 2.83L;

/// What it costs to solve with a matrix already made: of one unknown, the product with a rounded reciprocal; of the matrix
/// above, Gauss-Jordan elimination with pivoting, where sect. 14.4 has 2n (‖|A⁻¹||L||U|‖ + 3‖|U⁻¹||U|‖) = 4 (3.4 + 3·2.42).
template <class T>
inline constexpr Real solve_cost = 2;
template <>
inline constexpr Real solve_cost<Complex> = 43;

/// T is Real or Complex.
template <class T>
struct Rounded {
  T x{};
  Real e = 0;     ///< [u]
  Real peak = 0;  ///< the largest number met on the way to x

  Rounded() = default;
  Rounded(T value) : x{value}, peak{std::abs(value)} {}  // NOLINT: a number is one without error
  Rounded(T value, Real error, Real largest) : x{value}, e{error}, peak{std::max(largest, std::abs(value))} {}

  [[nodiscard]] Real size() const { return std::abs(x); }

  friend Rounded operator+(const Rounded& a, const Rounded& b) {
    const T sum = a.x + b.x;
    return {sum, a.e + b.e + std::abs(sum), std::max(a.peak, b.peak)};
  }
  friend Rounded operator-(const Rounded& a, const Rounded& b) {
    const T sum = a.x - b.x;
    return {sum, a.e + b.e + std::abs(sum), std::max(a.peak, b.peak)};
  }
  friend Rounded operator*(const Rounded& a, const Rounded& b) {
    const T product = a.x * b.x;
    return {product, a.e * b.size() + b.e * a.size() + product_cost<T> * std::abs(product), std::max(a.peak, b.peak)};
  }
  /// By a number that is no vector: one rounding, and one of the number's own.
  friend Rounded scaled(Real by, const Rounded& a) {
    const T product = static_cast<T>(by) * a.x;
    return {product, std::abs(by) * a.e + 2 * std::abs(product), a.peak};
  }
  /// A⁻¹ b
  friend Rounded solved(const Rounded& A, const Rounded& b) {
    const T quotient = b.x / A.x;
    return {quotient, (b.e + A.e * std::abs(quotient)) / A.size() + solve_cost<T> * std::abs(quotient),
            std::max(A.peak, b.peak)};
  }
};

}  // namespace stability
