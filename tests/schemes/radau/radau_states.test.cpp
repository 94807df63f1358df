// Radau IIA steps of every kind of state, with every kind of mass; units; failures.
#include <phistep/phistep.hpp>
#include <phistep/schemes/radau/radau.hpp>

#include <cmath>
#include <limits>

#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include "problems/van_der_pol.hpp"
#endif
#if PHISTEP_STRESS
#include "contract/states.hpp"
#endif

using namespace phistep;

#if PHISTEP_QUICK

using problems::distance;

TEST_CASE("backward and forward again, and from one time to another in two lengths") {
  const auto y = problems::VanDerPol::start();
  auto now = y;
  PhiStepper stepper{y, problems::VanDerPol{}, radau(7)};
  problems::step(stepper, now, 0.0, 0.1);
  problems::step(stepper, now, 0.1, -0.1);
  CHECK(distance(now, y) <= 1e-10);  // each way is right to order 13
}

TEST_CASE("failures leave the state as it was, and name themselves") {
  using V = Eigen::Vector2d;
  double poison = 0;
  const auto f = [&poison](const V& y) -> V { return {-y[0] + poison, -y[1] * y[1]}; };
  V y{1, 1};
  PhiStepper stepper{y, f, radau(3)};
  problems::step(stepper, y, 0.0, 0.1);
  const V before = y;
  poison = std::numeric_limits<double>::quiet_NaN();
  const StepReport report = stepper.step(y, 0.1, 0.1);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK(report.failure().index == 0);
  CHECK(y == before);
  poison = 0;
  // 1/λ₀ h J = 1: the real lane is singular.
  struct Growth {
    double lambda;
    Eigen::Matrix<double, 1, 1> operator()(const Eigen::Matrix<double, 1, 1>& x) const { return lambda * x; }
    Eigen::Matrix<double, 1, 1> jacobian(const Eigen::Matrix<double, 1, 1>&) const {
      return Eigen::Matrix<double, 1, 1>{lambda};
    }
  };
  Eigen::Matrix<double, 1, 1> x{1};
  const double lambda0 = radau_constants<double, 3>.lambda.re[0];
  CHECK(PhiStepper{x, Growth{lambda0}, radau(3)}.step(x, 0, 1).outcome() == Outcome::singular_matrix);
  CHECK(x[0] == 1);
  CHECK_THROWS_AS(radau(4), std::invalid_argument);
}

#elif PHISTEP_STRESS
// Radau IIA steps of every kind of state, with every kind of mass.

using problems::march;
using Vec = Eigen::VectorXd;

TEST_CASE("a mass matrix, a diagonal one and M = 1 agree where they mean the same") {
  const Eigen::Matrix3d M{{2, 0.5, 0}, {0.5, 1, 0.2}, {0, 0.2, 4}};
  const Eigen::Vector3d start{1, -0.5, 0.3};
  const auto f = [](const Eigen::Vector3d& y) -> Eigen::Vector3d {
    return {-30 * y[0] + y[1] * y[2], y[0] - y[1] * y[1] * y[1], std::sin(y[0]) - y[2]};
  };
  const auto solved = [f, M](const Eigen::Vector3d& y) -> Eigen::Vector3d { return M.partialPivLu().solve(f(y)); };
  Eigen::Vector3d a = start, b = start, c = start;
  a = march(PhiStepper{a, f, radau(5), capacity(M)}, a, 0.0, 1.0, 5);
  b = march(PhiStepper{b, solved, radau(5)}, b, 0.0, 1.0, 5);
  CHECK((a - b).norm() <= 1e-13);
  const Eigen::Vector3d m{2, 3, 5};
  a = march(PhiStepper{start, f, radau(3), capacity(m)}, start, 0.0, 1.0, 5);
  c = march(PhiStepper{start, f, radau(3), capacity(Eigen::Matrix3d{m.asDiagonal()})}, start, 0.0, 1.0, 5);
  CHECK((a - c).norm() <= 1e-14);
}

TEST_CASE("every kind of state: dynamic, matrix-shaped, several blocks, float and long double; units change no bit") {
  const auto decay = [](const auto& y) { return std::remove_cvref_t<decltype(y)>{-2 * y - y.cwiseProduct(y)}; };
  const auto run = [&](auto y, int stages) {
    using T = typename decltype(y)::Scalar;
    return march(PhiStepper{y, decay, radau(stages)}, y, T(0), T(1), 3);
  };
  const double exact = 2 / (2 * std::exp(2.0) + std::exp(2.0) - 1);  // y' = −2y − y², y(0) = 1
  for (const int stages : {3, 5, 7}) {
    CAPTURE(stages);
    // e^z − R = z⁶/7200 for 3 stages: 8e-4 at z = −4Δt, the first step's, of which most is damped.
    const double allowed = stages == 3 ? 1e-4 : 1e-8;
    CHECK(std::abs(run(Eigen::Vector2d{1, 1}, stages)[1] - exact) <= allowed);
    CHECK(std::abs(run(Vec{Vec::Ones(7)}, stages)[6] - exact) <= allowed);
    CHECK(std::abs(run(Eigen::Matrix3Xd{Eigen::Matrix3Xd::Ones(3, 4)}, stages)(2, 3) - exact) <= allowed);
    CHECK(std::abs(run(Eigen::Vector2f{1, 1}, stages)[1] - exact) <= std::max(allowed, 1e-5));
    CHECK(std::abs(run(Eigen::Matrix<long double, 2, 1>{1, 1}, stages)[1] - exact) <= allowed);
  }
  states::Coupled c;
  PhiStepper warm{c.state, states::WarmPull{}, radau(3)};
  REQUIRE(warm.step(c.state, 0, 0.1));
  // Powers of two in length and time.
  using V1 = Eigen::Matrix<double, 1, 1>;
  const auto scaled = [](double length, double time) {
    Motion<V1> y{V1{0.7 * length}, V1{-0.4 * length / time}};
    const auto f = [=](const V1& r, const V1& v) {
      const double x = r[0] / length, w = v[0] * time / length;
      return V1{(-(4 + x * x) * x - w * w * w) * (length / (time * time))};
    };
    y = march(PhiStepper{y, f, radau(5)}, y, 0.0, 1.2 * time, 4);
    return Eigen::Vector2d{y.r[0] / length, y.v[0] * time / length};
  };
  const Eigen::Vector2d here = scaled(1, 1);
  for (const double unit : {std::exp2(-30), std::exp2(40)}) {
    CHECK(scaled(unit, 1) == here);
    CHECK(scaled(1, unit) == here);
  }
}

TEST_CASE("failures leave the state as it was, and name themselves") {
  Eigen::Matrix<double, 1, 1> x{1};
  // No solution in reach: the iteration says so, and ends.
  const auto jump = [](const Eigen::Matrix<double, 1, 1>& z) {
    return Eigen::Matrix<double, 1, 1>{z[0] > 0 ? -1e3 : 2e3};
  };
  const StepReport stuck = PhiStepper{x, jump, radau(5)}.step(x, 0, 1);
  CHECK((stuck.outcome() == Outcome::newton_stalled || stuck.outcome() == Outcome::newton_diverged));
  CHECK(x[0] == 1);
}

#endif
