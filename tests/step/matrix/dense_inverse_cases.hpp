// What dense_inverse.test.cpp and dense_inverse.full.cpp share.
#pragma once

#include <phistep/step/matrix/dense_inverse.hpp>

#include "step/matrix/dense_battery.hpp"
#include "step/matrix/dense_sizes.hpp"

namespace dense_inverse_cases {

using phistep::DenseInverse;

template <class Scalar>
struct Inverse {
  template <int n>
  using OfSize = DenseInverse<Scalar, n>;
};

// Each column of X has a residual of at most 8 n u |L||U||U⁻¹||U||X| (Higham, Accuracy and Stability of Numerical
// Algorithms, 2nd ed., theorem 14.5), and the product X b adds n u |A||X||b|, which is smaller.
inline void solves_to_rounding(int n, const dense::Make& make) {
  dense::solves(n, make, [](const dense::Matrix& A, dense::Subject& solver, const dense::Vector& b, const auto&) {
    return dense::times(dense::Elimination(A).gauss_jordan,
                        dense::times(dense::absolute(solver.matrix()), dense::absolute(b)));
  });
}

}  // namespace dense_inverse_cases
