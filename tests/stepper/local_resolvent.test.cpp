// Particles that don't act on each other: each is solved by itself, and stops when it has converged.
#include <phistep/autodiff.hpp>
#include <phistep/io/checkpoint.hpp>

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

namespace {

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
Motion<Matrix3Xd> crowd(Eigen::Index N) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Motion<Matrix3Xd> y{Matrix3Xd(3, N), Matrix3Xd(3, N)};
  for (auto& x : y.r.reshaped()) x = 0.1 * normal(random);
  for (auto& x : y.v.reshaped()) x = normal(random);
  for (const Eigen::Index i : {2, 5, 11}) y.r.col(i) *= 30;
  return y;
}

Motion<Vector3d> particle(const Motion<Matrix3Xd>& y, Eigen::Index i) { return {y.r.col(i), y.v.col(i)}; }

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

}  // namespace

TEST_CASE("each particle takes its own iterations and gets the bits that it has alone") {
  SECTION("with a Jacobian") { check_alone_and_among_others(local<3>(WellWithJacobian{}), trapezoidal); }
  SECTION("by differences") { check_alone_and_among_others(local<3>(Well{}), trapezoidal); }
  SECTION("by automatic differentiation") {
    const auto force = autodiff([](const auto& r, const auto& v) {
      return typename std::remove_cvref_t<decltype(r)>(-r - r.squaredNorm() * r - 0.2 * v);
    });
    check_alone_and_among_others(local<3>(force), trapezoidal);
  }
  SECTION("backward Euler") { check_alone_and_among_others(local<3>(WellWithJacobian{}), backward_euler); }
  SECTION("stage form") { check_alone_and_among_others(local<3>(WellWithJacobian{}), midpoint); }
  SECTION("phi = 0.7, which carries the force") { check_alone_and_among_others(local<3>(Well{}), phi(0.7)); }
  SECTION("Gravity and LinearDrag beside it") {
    check_alone_and_among_others(local<3>(WellWithJacobian{}) + Gravity{Vector3d(0, 0, -1)} + LinearDrag{0.5},
                                 trapezoidal, mass(2.0));
  }
}

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
  SECTION("flat motion") {
    const Motion<Matrix3Xd> start = crowd(12);
    Motion<Matrix3Xd> y = start;
    Motion<Vec> z{start.r.reshaped(), start.v.reshaped()};
    PhiStepper a{y, local<3>(WellWithJacobian{}), trapezoidal};
    PhiStepper b{z, local<3>(WellWithJacobian{}), trapezoidal};
    REQUIRE(a.step(y, 0, 0.1));
    REQUIRE(b.step(z, 0, 0.1));
    CHECK((y.r.reshaped().array() == z.r.array()).all());
  }
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
      const Eigen::Vector2d expected =
          (Eigen::Matrix2d::Identity() - h * A(t1)).partialPivLu().solve(start.segment<2>(2 * i));
      CHECK((y.segment<2>(2 * i) - expected).norm() <= 1e-14 * expected.norm());
    }
  }
}

TEST_CASE("an affine local force is factorised once a run, without any matrix between particles") {
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
  Motion<Vec> y{Vec::Zero(7), Vec::Zero(7)};
  CHECK_THROWS_AS((PhiStepper{y, local<3>(Well{}), backward_euler}), std::invalid_argument);
  Motion<Eigen::MatrixXd> z{Eigen::MatrixXd::Zero(2, 6), Eigen::MatrixXd::Zero(2, 6)};
  CHECK_THROWS_AS((PhiStepper{z, local<3>(Well{}), backward_euler}), std::invalid_argument);
}

TEST_CASE("a checkpoint has the pace of each particle's solves: the next step's bits are the same") {
  const auto check = [](auto go) {
    Motion<Matrix3Xd> y = crowd(14), z = y;
    PhiStepper stepper{y, local<3>(WellWithJacobian{}), backward_euler},
        other{z, local<3>(WellWithJacobian{}), backward_euler};
    go(stepper, y, 0.0);
    std::stringstream bytes;
    save_checkpoint(bytes, stepper, y);
    load_checkpoint(bytes, other, z);
    go(stepper, y, 1.0);
    go(other, z, 1.0);
    CHECK((y.r.array() == z.r.array()).all());
    CHECK((y.v.array() == z.v.array()).all());
    CHECK(stepper.statistics() == other.statistics());
  };
  check([](auto& stepper, auto& y, double t) {
    for (int k = 0; k < 10; ++k) REQUIRE(stepper.step(y, t, 1e-4));
  });
  check([](auto& stepper, auto& y, double t) {
    REQUIRE(integrate(stepper, y, {t, t + 1}, tolerance{.rtol = 1e-5, .atol = 1e-7}));
  });
}
