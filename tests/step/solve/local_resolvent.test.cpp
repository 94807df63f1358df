// Particles that don't act on each other: each is solved by itself, and stops when it has converged.
#include "step/solve/local_resolvent_cases.hpp"
#if PHISTEP_STRESS
#include <phistep/autodiff.hpp>
#endif

using namespace local_resolvent_cases;

#if PHISTEP_FULL

TEST_CASE("each particle takes its own iterations and gets the bits that it has alone") {
  check_alone_and_among_others(local<3>(Well{}), phi(0.7));
}

TEST_CASE("the Jacobian of a local force by differences costs dim or 2 dim calls, however many particles there are") {
  // 2100 unknowns: a dense Jacobian would be refused. All alike, so that one particle has the most of everything.
  Motion<Matrix3Xd> y{Vector3d(0.1, -0.2, 0.3).replicate(1, 700), Vector3d(1, 0.5, -1).replicate(1, 700)};
  PhiStepper stepper{y, local<3>(Well{}), phi(0.4)};
  REQUIRE(stepper.step(y, 0, 0.01));
  const Statistics& s = stepper.statistics();
  CHECK(s.force_calls == 1 + s.iterations + 6 * s.jacobians);  // one at the start
  CHECK(s.jacobians >= 1);
  CHECK(s.jacobians <= s.iterations);
  CHECK(s.active_iterations == 700 * s.iterations);
}

TEST_CASE("a flat vector of particles, and groups of a first-order state") {
  SECTION("first order, with time: y' = A(t) y for pairs") {
    Vec y = Vec::LinSpaced(8, 1, 8);
    const Vec start = y;
    const double t1 = 0.1, h = 0.1;
    const auto A = [](double t) {
      Eigen::Matrix2d a;
      a << -3, 1 + t, 0.5, -1;
      return a;
    };
    PhiStepper stepper{y, local<2>([&A](const Eigen::Vector2d& x, double t) -> Eigen::Vector2d { return A(t) * x; }),
                       backward_euler};
    REQUIRE(stepper.step(y, 0, h));
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector2d expected = (Eigen::Matrix2d::Identity() - h * A(t1)).inverse() * start.segment<2>(2 * i);
      CHECK((y.segment<2>(2 * i) - expected).norm() <= 1e-14 * expected.norm());
    }
  }
}

TEST_CASE("the particle whose equations fail is named, and nothing has moved") {
  Motion<Matrix3Xd> y = crowd(14);
  SECTION("a singular block, each by itself") {
    struct Push {  // backward Euler with h = 1: W = 1 − K, singular for K = 1
      Vector3d operator()(const Vector3d& r) const { return r.norm() > 1000 ? Vector3d(r) : Vector3d(-r); }
      [[nodiscard]] static Matrix3d jacobian(const Vector3d& r) {
        return r.norm() > 1000 ? Matrix3d(Matrix3d::Identity()) : Matrix3d(-Matrix3d::Identity());
      }
    };
    y.r.col(9) *= 1e6;
    const Motion<Matrix3Xd> before = y;
    PhiStepper stepper{y, local<3>(Push{}), backward_euler};
    const StepReport report = stepper.step(y, 0, 1);
    CHECK(report.outcome() == Outcome::singular_matrix);
    CHECK(report.failure().particle == 9);
    CHECK_THAT(report.message(), contains("particle 9"));
    CHECK((y.r.array() == before.r.array()).all());
  }
}

TEST_CASE("what does not fit is refused") {
  Motion<Vec> y{Vec::Zero(7), Vec::Zero(7)};
  CHECK_THROWS_AS((PhiStepper{y, local<3>(Well{}), backward_euler}), std::invalid_argument);
}

#elif PHISTEP_STRESS
// Particles solved one by one, by every scheme and tangent.

TEST_CASE("the Jacobian of a local force by differences costs dim or 2 dim calls, however many particles there are") {
  // 2100 unknowns: a dense Jacobian would be refused. All alike, so that one particle has the most of everything.
  Motion<Matrix3Xd> y{Vector3d(0.1, -0.2, 0.3).replicate(1, 700), Vector3d(1, 0.5, -1).replicate(1, 700)};
  SECTION("of r and v") {
    PhiStepper stepper{y, local<3>(Well{}), backward_euler};
    REQUIRE(stepper.step(y, 0, 0.01));
    const Statistics& s = stepper.statistics();
    CHECK(s.force_calls == s.iterations + 6 * s.jacobians);
    CHECK(s.jacobians >= 1);
    CHECK(s.jacobians <= s.iterations);
    CHECK(s.active_iterations == 700 * s.iterations);
  }
  SECTION("of r") {
    PhiStepper stepper{y, local<3>([](const Vector3d& r) -> Vector3d { return -r.squaredNorm() * r; }), backward_euler};
    REQUIRE(stepper.step(y, 0, 0.01));
    const Statistics& s = stepper.statistics();
    CHECK(s.force_calls == s.iterations + 3 * s.jacobians);
  }
  SECTION("of v alone, for Verlet's second kick") {
    PhiStepper stepper{y, local<3>([](const Vector3d& r, const Vector3d& v) -> Vector3d { return -r - v.norm() * v; }),
                       velocity_verlet};
    REQUIRE(stepper.step(y, 0, 0.01));
    const Statistics& s = stepper.statistics();
    CHECK(s.force_calls == 1 + s.iterations + 3 * s.jacobians);
  }
}

TEST_CASE("a local force steps a state as the same force written for all particles does") {
  Motion<Matrix3Xd> y = crowd(14), z = y;
  const Eigen::VectorXd masses = Eigen::VectorXd::LinSpaced(14, 1, 3);
  const auto whole = [](const Matrix3Xd& r, const Matrix3Xd& v) -> Matrix3Xd {
    return -r - (r.array().rowwise() * r.colwise().squaredNorm().array()).matrix() - 0.2 * v;
  };
  for (const double f : {0.5, 0.7, 1.0}) {
    PhiStepper a{y, local<3>(WellWithJacobian{}), phi(f), mass(masses)};
    PhiStepper b{z, whole, phi(f), mass(masses)};
    for (int k = 0; k < 4; ++k) {
      REQUIRE(a.step(y, 0, 0.1));
      REQUIRE(b.step(z, 0, 0.1));
    }
    // Both solve to rounding; W's condition is below 10.
    CHECK((y.r - z.r).norm() <= 1e-13 * z.r.norm());
    CHECK((y.v - z.v).norm() <= 1e-13 * z.v.norm());
  }
}

TEST_CASE("a flat vector of particles, and groups of a first-order state") {
  const Motion<Matrix3Xd> start = crowd(12);
  Motion<Matrix3Xd> y = start;
  Motion<Vec> z{start.r.reshaped(), start.v.reshaped()};
  PhiStepper a{y, local<3>(WellWithJacobian{}), trapezoidal};
  PhiStepper b{z, local<3>(WellWithJacobian{}), trapezoidal};
  REQUIRE(a.step(y, 0, 0.1));
  REQUIRE(b.step(z, 0, 0.1));
  CHECK((y.r.reshaped().array() == z.r.array()).all());
}

TEST_CASE("an affine local force is factorized once a run, without any matrix between particles") {
  Motion<Matrix3Xd> y = crowd(1000);
  struct Spring {
    Vector3d operator()(const Vector3d& r) const { return Vector3d(-1, -2, -3).cwiseProduct(r); }
    [[nodiscard]] static Matrix3d jacobian(const Vector3d& /*r*/) { return Vector3d(-1, -2, -3).asDiagonal(); }
  };
  PhiStepper stepper{y, affine(local<3>(Spring{})) + LinearDrag{0.1}, trapezoidal};
  for (int k = 0; k < 10; ++k) REQUIRE(stepper.step(y, 0, 0.1));
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 1);
  CHECK(stepper.statistics().active_iterations == 0);
}

TEST_CASE("the particle whose equations fail is named, and nothing has moved") {
  Motion<Matrix3Xd> y = crowd(14);
  const Motion<Matrix3Xd> start = y;
  SECTION("a singular block in one matrix for all") {
    struct Push {
      Vector3d operator()(const Vector3d& r) const { return r; }
      [[nodiscard]] static Matrix3d jacobian(const Vector3d& /*r*/) { return Matrix3d::Identity(); }
    };
    Eigen::VectorXd masses = Eigen::VectorXd::Constant(14, 2.0);
    masses[4] = 1;  // W = m − h² K = 0 for this one
    PhiStepper stepper{y, affine(local<3>(Push{})), backward_euler, mass(masses)};
    const StepReport report = stepper.step(y, 0, 1);
    CHECK(report.outcome() == Outcome::singular_matrix);
    CHECK(report.failure().particle == 4);
    CHECK((y.r.array() == start.r.array()).all());
  }
  SECTION("a force that isn't finite") {
    const auto f = [](const Vector3d& r) -> Vector3d { return r.norm() > 50 ? Vector3d::Constant(NAN) : Vector3d(-r); };
    y.r.col(2) *= 1e3;
    PhiStepper stepper{y, local<3>(f), backward_euler};
    const StepReport report = stepper.step(y, 0, 0.1);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(report.failure().column == 2);
  }
}

TEST_CASE("what does not fit is refused") {
  Motion<Eigen::MatrixXd> z{Eigen::MatrixXd::Zero(2, 6), Eigen::MatrixXd::Zero(2, 6)};
  CHECK_THROWS_AS((PhiStepper{z, local<3>(Well{}), backward_euler}), std::invalid_argument);
}

#endif
