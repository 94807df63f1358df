#pragma once

// What method.test.cpp and its full half share.

#include <phistep/phistep.hpp>
#include <phistep/study/stability/method.hpp>

#include <cmath>
#include <complex>

#include "instances/preflight.hpp"
#include "support/catch.hpp"

namespace method_cases {

using namespace phistep;
using Eigen::MatrixXd;
using Kind = Method::Kind;

/// The step's matrix, column by column, as the stepper does it: r'' = K r + C v in three dimensions.
template <class Scheme>
void compare_with_stepper(Scheme scheme) {
  Eigen::Matrix3d K, C;
  K << -4, 1, 0.5, 1, -9, 2, 0.5, 2, -3;
  C << -0.3, 0.7, 0, -0.7, -0.2, 0.1, 0, -0.1, -0.5;
  const double h = 0.3;
  const MatrixXd G = step_matrix(method_of(scheme), {K, C}, h);
  for (int j = 0; j < 6; ++j) {
    Motion state{Eigen::Vector3d(Eigen::Vector3d::Zero()), Eigen::Vector3d(Eigen::Vector3d::Zero())};
    (j < 3 ? state.r : state.v)[j % 3] = 1;
    PhiStepper stepper{state, linear(K, C), scheme};
    REQUIRE(stepper.step(state, 0.0, h));
    // Some ten roundings of numbers of order one.
    CHECK((state.r - G.col(j).head(3)).norm() < 1e-14);
    CHECK((state.v - G.col(j).tail(3)).norm() < 1e-14);
  }
}

}  // namespace method_cases
