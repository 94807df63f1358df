// What dense_lu.test.cpp and dense_lu.full.cpp share.
#pragma once

#include <phistep/step/matrix/small_dense_lu.hpp>

#include "step/matrix/dense_battery.hpp"
#include "step/matrix/dense_sizes.hpp"

namespace dense_lu_cases {

using phistep::DenseLu;

template <class Scalar>
struct Lu {
  template <int n>
  using OfSize = DenseLu<Scalar, n>;
};

// Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., theorem 9.4: |A x − b| ≤ γ_3n |L||U||x|.
inline dense::Vector of_elimination(const dense::Matrix& A, dense::Subject&, const dense::Vector&,
                                    const dense::Vector& x) {
  return dense::times(dense::Elimination(A).product, dense::absolute(x));
}
// Without scaling there is next to no growth: |A x − b|_i ≤ c n u Σ_j |a_ij| ‖x‖.
inline dense::Vector of_rows(const dense::Matrix& A, dense::Subject&, const dense::Vector&, const dense::Vector& x) {
  long double largest = 0;
  for (const long double each : x) largest = std::max(largest, std::abs(each));
  const dense::Vector all = dense::Vector::Constant(x.size(), largest);
  return dense::times(dense::absolute(A), all);
}
inline void solves_to_rounding(int n, const dense::Make& make) {
  dense::solves(n, make, of_elimination);
  dense::solves(n, make, of_rows, false);
}

}  // namespace dense_lu_cases
