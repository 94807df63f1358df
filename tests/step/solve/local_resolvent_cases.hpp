#pragma once

// What the quick and the full half of step/solve/local_resolvent share.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Vec = Eigen::VectorXd;

namespace local_resolvent_cases {

/// −k r − q |r|² r − c v: a well, anharmonic, with drag.
struct Well {
  double k = 1, q = 1, c = 0.2;
  Vector3d operator()(const Vector3d& r, const Vector3d& v) const { return -k * r - q * r.squaredNorm() * r - c * v; }
};
struct WellWithJacobian : Well {
  [[nodiscard]] MotionJacobian<Matrix3d> jacobian(const Vector3d& r, const Vector3d& /*v*/) const {
    const Matrix3d I = Matrix3d::Identity();
    return {-k * I - q * (r.squaredNorm() * I + 2 * r * r.transpose()), -c * I};
  }
};

/// N particles at random places; particles 2, 5 and 11 far out, where the well is anharmonic and Newton needs more.
inline Motion<Matrix3Xd> crowd(Eigen::Index N) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Motion<Matrix3Xd> y{Matrix3Xd(3, N), Matrix3Xd(3, N)};
  for (auto& x : y.r.reshaped()) x = 0.1 * normal(random);
  for (auto& x : y.v.reshaped()) x = normal(random);
  for (const Eigen::Index i : {2, 5, 11}) y.r.col(i) *= 30;
  return y;
}

inline Motion<Vector3d> particle(const Motion<Matrix3Xd>& y, Eigen::Index i) { return {y.r.col(i), y.v.col(i)}; }

template <class F, class... More>
void check_alone_and_among_others(F force, auto scheme, const More&... more) {
  constexpr int steps = 5;
  const double dt = 0.3;
  Motion<Matrix3Xd> all = crowd(14);
  PhiStepper together{all, force, scheme, more...};
  std::int64_t sum = 0;
  Motion<Matrix3Xd> alone = all;
  std::vector<std::int64_t> iterations_of_step(steps, 0);
  for (Eigen::Index i = 0; i < all.r.cols(); ++i) {
    Motion<Vector3d> y = particle(all, i);
    PhiStepper stepper{y, force, scheme, more...};
    for (int k = 0; k < steps; ++k) {
      const StepReport report = stepper.step(y, k * dt, dt);
      INFO(report.message());
      REQUIRE(report);
      auto& deepest = iterations_of_step[static_cast<std::size_t>(k)];
      deepest = std::max<std::int64_t>(deepest, report.iterations());
    }
    sum += stepper.statistics().iterations;
    CHECK(stepper.statistics().iterations == stepper.statistics().active_iterations);
    alone.r.col(i) = y.r;
    alone.v.col(i) = y.v;
  }
  std::int64_t deepest = 0;
  for (int k = 0; k < steps; ++k) {
    const StepReport report = together.step(all, k * dt, dt);
    REQUIRE(report);
    CHECK(report.iterations() == iterations_of_step[static_cast<std::size_t>(k)]);
    deepest += report.iterations();
  }
  CHECK((all.r.array() == alone.r.array()).all());
  CHECK((all.v.array() == alone.v.array()).all());
  CHECK(together.statistics().active_iterations == sum);
  CHECK(together.statistics().iterations == deepest);
  // The hard ones need more than the others do.
  CHECK(sum < 14 * deepest);
  INFO("sum " << sum << ", all as deep as the deepest " << 14 * deepest);
}

}  // namespace local_resolvent_cases
