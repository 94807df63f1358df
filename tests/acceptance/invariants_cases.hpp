#pragma once

// What both halves of acceptance/invariants need: steps whose invariants are looked at.

#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

#include "problems/forced.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "problems/show_digits.hpp"
#include "problems/spring_net.hpp"
#include "support/catch.hpp"

using problems::HardeningSpring;
using problems::Kepler;
using problems::SpringNet;

namespace {

/// max |L − L₀| over n steps, 400 a period.
double angular_momentum_error(auto scheme, int n) {
  const Kepler kepler;
  Kepler::State y = kepler.start();
  phistep::PhiStepper stepper{y, kepler, scheme};
  const double h = Kepler::period / 400, start = Kepler::angular_momentum(y);
  double worst = 0;
  for (int k = 0; k < n; ++k) {
    problems::step(stepper, y, k * h, h);
    worst = std::max(worst, std::abs(Kepler::angular_momentum(y) - start));
  }
  return worst;
}

/// The momentum of a net over 200 steps.
[[maybe_unused]] void check_momentum_of(const std::function<void(SpringNet::State& y, double t, double h)>& step,
                                        double h) {
  SpringNet::State y = SpringNet::start();
  const Eigen::Vector2d before = SpringNet::momentum(y);
  const double scale = y.v.cwiseAbs().dot(SpringNet::masses());
  double worst = 0;
  for (int n = 0; n < 200; ++n) {
    step(y, n * h, h);
    worst = std::max(worst, (SpringNet::momentum(y) - before).norm() / scale);
  }
  CAPTURE(worst);
  CHECK(worst <= 1e-13);
}
void check_momentum(const auto& force, auto scheme, double h) {
  phistep::PhiStepper stepper{SpringNet::start(), force, scheme, phistep::mass(SpringNet::masses())};
  check_momentum_of([&](SpringNet::State& y, double t, double by) { problems::step(stepper, y, t, by); }, h);
}

/// |JᵀΩJ − Ω| of one step's Jacobian J, by central differences.
[[maybe_unused]] double symplecticity_defect_of(const std::function<void(HardeningSpring::State& y, double h)>& step) {
  using Matrix = Eigen::Matrix4d;
  constexpr double h = 0.3, delta = 1e-5;  // truncation δ² and rounding u/δ: 1e-10 and 1e-11
  const auto image = [&](int column, double by) {
    HardeningSpring::State z = HardeningSpring::start();
    (column < 2 ? z.r[column] : z.v[column - 2]) += by;
    step(z, h);
    return Eigen::Vector4d{z.r[0], z.r[1], z.v[0], z.v[1]};
  };
  Matrix J, omega = Matrix::Zero();
  for (int k = 0; k < 4; ++k) J.col(k) = (image(k, delta) - image(k, -delta)) / (2 * delta);
  omega.topRightCorner<2, 2>().setIdentity();
  omega.bottomLeftCorner<2, 2>() = -Eigen::Matrix2d::Identity();
  return (J.transpose() * omega * J - omega).cwiseAbs().maxCoeff();
}

double symplecticity_defect(auto scheme) {
  phistep::PhiStepper stepper{HardeningSpring::start(), HardeningSpring{}, scheme};
  return symplecticity_defect_of([&](HardeningSpring::State& y, double h) { problems::step(stepper, y, 0.0, h); });
}

}  // namespace
