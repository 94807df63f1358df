#pragma once

#include <Eigen/Core>

#include <complex>

namespace problems {

/// y' = λ y, whose φ-step multiplies y by R(λΔt) in either form.
struct Dahlquist {
  using State = Eigen::Matrix<double, 1, 1>;
  double lambda;  ///< [1/time]

  State operator()(const State& y) const { return lambda * y; }
  State jacobian(const State& /*y*/) const { return State{lambda}; }
};

/// The same with a complex λ = α + iβ, y as (Re y, Im y).
struct ComplexDahlquist {
  using State = Eigen::Vector2d;
  std::complex<double> lambda;

  [[nodiscard]] Eigen::Matrix2d jacobian(const State& /*y*/) const {
    return Eigen::Matrix2d{{lambda.real(), -lambda.imag()}, {lambda.imag(), lambda.real()}};
  }
  State operator()(const State& y) const { return jacobian(y) * y; }
};

/// The stability function R(z) = (1 + (1−φ)z)/(1 − φz).
template <class Z>
[[nodiscard]] Z amplification(Z z, double phi) {
  using T = decltype(std::abs(z));
  const T weight = static_cast<T>(phi);
  return (T{1} + (T{1} - weight) * z) / (T{1} - weight * z);
}

}  // namespace problems
