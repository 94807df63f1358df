// Particles that don't act on each other: each is solved by itself, and stops when it has converged.
#include "step/solve/local_resolvent_cases.hpp"

using namespace local_resolvent_cases;

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
