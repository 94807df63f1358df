// What linear.test.cpp and linear.full.cpp share.
#pragma once

#include <phistep/sparse.hpp>

#include <functional>

#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;
using Y = Motion<Vec>;

namespace linear_cases {

template <class F>
using OfMotion = ForceTraits<F, MotionView<Vec, UnitMass>, Y::Rate>;
template <class F>
using OfVector = ForceTraits<F, FirstOrderView<Vec, UnitMass>, RateOf<Vec>>;

inline const auto hooke = [](const Vec& r) -> Vec { return -2 * r; };
using Hooke = decltype(hooke);
inline double one(double) { return 1; }

}  // namespace linear_cases
