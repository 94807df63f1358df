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

/// K and C at random, and a motion.
struct Random {
  Mat K = Mat::Random(6, 6), C = Mat::Random(6, 6);
  Y y{Vec::LinSpaced(6, -1, 1), Vec::LinSpaced(6, 2, 3)};
};
/// Ψ at y: what a step of 1 adds to v.
Vec psi(const Y& y, const auto& force) {
  PhiStepper stepper{y, force, forward_euler};
  Y next = y;
  REQUIRE(stepper.step(next, 0, 1));
  return next.v - y.v;
}
inline constexpr double rounding = 1e-14;

}  // namespace linear_cases
