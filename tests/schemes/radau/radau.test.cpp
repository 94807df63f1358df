// Radau IIA steps of 3, 5 and 7 stages: order, stability, stiff accuracy, counts, failures, every kind of state.
#include <phistep/phistep.hpp>
#include <phistep/schemes/radau/radau.hpp>

#include <cmath>
#include <limits>

#include "accuracy/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "problems/prothero_robinson.hpp"
#include "problems/van_der_pol.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;
using Vec = Eigen::VectorXd;

namespace {

/// One step of y' = λy from 1 with Δt = 1: R(z).
double amplification(int stages, double z) {
  const problems::Dahlquist problem{z};
  problems::Dahlquist::State y{1};
  PhiStepper stepper{y, problem, radau(stages)};
  problems::step(stepper, y, 0.0, 1.0);
  return y[0];
}
/// The Padé approximant (s−1, s) of the exponential (HW II, theorem IV.3.9).
double pade(int s, double z) {
  const int k = s - 1, j = s;
  long double P = 1, Q = 1, p = 1, q = 1;
  for (int m = 1; m <= j; ++m) {
    p *= m <= k ? static_cast<long double>(k - m + 1) / ((j + k - m + 1) * static_cast<long double>(m)) * z : 0;
    q *= -static_cast<long double>(j - m + 1) / ((j + k - m + 1) * static_cast<long double>(m)) * z;
    P += p, Q += q;
  }
  return static_cast<double>(P / Q);
}

/// r'' = −(4 + r²) r − v³ − v/2 + cos t, as a motion and as two equations.
struct Pushed {
  using Vector = Eigen::Matrix<double, 1, 1>;
  Vector operator()(const Vector& r, const Vector& v, double t) const {
    return Vector{-(4 + r[0] * r[0]) * r[0] - v[0] * v[0] * v[0] - 0.5 * v[0] + std::cos(t)};
  }
  MotionJacobian<Vector, Vector> jacobian(const Vector& r, const Vector& v, double) const {
    return {Vector{-4 - 3 * r[0] * r[0]}, Vector{-3 * v[0] * v[0] - 0.5}};
  }
};
struct PushedFlow {
  Eigen::Vector2d operator()(const Eigen::Vector2d& y, double t) const {
    using V = Pushed::Vector;
    return {y[1], Pushed{}(V{y[0]}, V{y[1]}, t)[0]};
  }
  Eigen::Matrix2d jacobian(const Eigen::Vector2d& y, double) const {
    return Eigen::Matrix2d{{0, 1}, {-4 - 3 * y[0] * y[0], -3 * y[1] * y[1] - 0.5}};
  }
};

}  // namespace

TEST_CASE("orders 5 and 9: a flow and a damped motion, non-autonomous, nonlinear, with a mass") {
  using Flow = problems::ForcedFlow<>;
  using Moved = problems::ForcedMotion<>;
  const auto flow = [](int stages) {
    return [stages](int steps) {
      const auto y = Flow::exact(0);
      PhiStepper stepper{y, Flow{}, radau(stages), capacity(Flow::capacity)};
      return distance(march(stepper, y, 0.0, 2.0, steps), Flow::exact(2));
    };
  };
  const auto moved = [](int stages) {
    return [stages](int steps) {
      const auto y = Moved::exact(0);
      PhiStepper stepper{y, Moved{}, radau(stages), mass(Moved::mass)};
      return distance(march(stepper, y, 0.0, 2.0, steps), Moved::exact(2));
    };
  };
  check_order(errors(5, flow(3)), 5, 0.3);
  check_order(errors(5, moved(3)), 5, 0.3);
  // Three halvings of order 9 are eight decades: two are in reach of double precision.
  const auto ninth = [](auto run) {
    const double a = run(2), b = run(4), c = run(8);
    CAPTURE(a, b, c);
    CHECK(std::abs(std::log2(a / b) - 9) <= 1.5);
    CHECK(std::abs(std::log2(b / c) - 9) <= 0.8);
  };
  ninth(flow(5));
  ninth(moved(5));
}

TEST_CASE("order 13, in long double") {
  using Flow = problems::ForcedFlow<long double>;
  const auto run = [](int steps) {
    const auto y = Flow::exact(0);
    PhiStepper stepper{y, Flow{}, radau(7), capacity(Flow::capacity)};
    return distance(march(stepper, y, 0.0L, 8.0L, steps), Flow::exact(8));
  };
  // From 1e-11 on the rounding of the tableau's eigenvectors is near.
  const double a = run(6), b = run(8), c = run(10);
  CAPTURE(a, b, c);
  CHECK(std::abs(std::log(a / b) / std::log(8.0 / 6) - 13) <= 1.5);
  CHECK(std::abs(std::log(b / c) / std::log(10.0 / 8) - 13) <= 1.5);
}

TEST_CASE("R(z) is the Pade approximant, and vanishes at infinity") {
  for (const int s : {3, 5, 7})
    for (const double z : {-1e-3, -0.1, -1.0, -5.0, -40.0, -1e3, -1e6, 0.5}) {
      CAPTURE(s, z);
      // Right to some roundings, as T, T⁻¹ (largest entries' product: 4, 60, 2e3) work on what Newton's iteration leaves only.
      CHECK(std::abs(amplification(s, z) - pade(s, z)) <= 16 * 2.3e-16);
    }
  for (const int s : {3, 5, 7}) {
    CAPTURE(s);
    // |R(z)| → s²/|z| (2s−1)!-free: y⁺ = y + Z_s cancels, to rounding of the transformation.
    CHECK(std::abs(amplification(s, -1e10)) < 1e-9);
  }
}

TEST_CASE("stiffly accurate: what is stiff costs no digits (Prothero-Robinson)") {
  const auto error = [](int stages, int steps) {
    const problems::ProtheroRobinson problem{-1e6};
    const auto y = problem.exact(0);
    return distance(march(PhiStepper{y, problem, radau(stages)}, y, 0.0, 1.0, steps), problem.exact(1));
  };
  // HW II, sect. IV.15: the error is O(h^{s+1}/z) + rounding: for s = 3, N = 10, h⁴ |y⁗|/(4! |λ| h) ~ 1e-12.
  CHECK(error(3, 10) < 1e-10);
  CHECK(error(5, 10) < 1e-13);
  CHECK(error(7, 10) < 1e-13);
  CHECK(error(3, 2) > error(3, 10));
}

TEST_CASE("a motion is the first-order system of twice its unknowns, step by step") {
  for (const int stages : {3, 5, 7}) {
    CAPTURE(stages);
    Motion<Pushed::Vector> y{Pushed::Vector{0.7}, Pushed::Vector{-0.4}};
    Eigen::Vector2d flow{0.7, -0.4};
    PhiStepper motion{y, Pushed{}, radau(stages)};
    PhiStepper plain{flow, PushedFlow{}, radau(stages)};
    for (int k = 0; k < 8; ++k) {
      problems::step(motion, y, 0.3 * k, 0.3);
      problems::step(plain, flow, 0.3 * k, 0.3);
    }
    // Both to the rounding of their iterations, amplified by T (2e3 for 7 stages), over 8 steps.
    CHECK(std::abs(y.r[0] - flow[0]) <= 1e-12);
    CHECK(std::abs(y.v[0] - flow[1]) <= 1e-12);
  }
}

TEST_CASE("exact counts: s force calls an iteration, one Jacobian and one factorization a step") {
  const auto y = problems::VanDerPol::start();
  auto now = y;
  PhiStepper stepper{y, problems::VanDerPol{}, radau(5)};
  for (int k = 0; k < 6; ++k) problems::step(stepper, now, 0.01 * k, 0.01);
  const Statistics& s = stepper.statistics();
  CHECK(s.steps == 6);
  CHECK(s.jacobians == 6);
  CHECK(s.factorizations == 6);
  CHECK(s.force_calls == 5 * s.iterations);
  CHECK(s.solves == s.iterations);
  CHECK(s.iterations <= 6 * 12);  // θ ~ 1e-2 here: six or seven to rounding
  CHECK(stepper.order() == 9);
  CHECK(PhiStepper{y, problems::VanDerPol{}, radau}.order() == 5);
  CHECK(std::string(stepper.solver_name()) == "dense LU");
}

TEST_CASE("an affine force: its Jacobian once, its matrices once a length") {
  struct Decay {
    Eigen::Vector2d operator()(const Eigen::Vector2d& y) const { return {-50 * y[0] + y[1], -y[1]}; }
    Eigen::Matrix2d jacobian(const Eigen::Vector2d&) const { return Eigen::Matrix2d{{-50, 1}, {0, -1}}; }
  };
  Eigen::Vector2d y{1, 1};
  PhiStepper stepper{y, affine(Decay{}), radau(3)};
  for (int k = 0; k < 5; ++k) problems::step(stepper, y, 0.1 * k, 0.1);
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 1);
  problems::step(stepper, y, 0.5, 0.2);
  CHECK(stepper.statistics().factorizations == 2);
  // y_1 follows y_2/49 after its own transient, exp(−50·0.7): order 5 at h = 0.1 leaves (0.1)⁵/7200.
  CHECK(std::abs(y[1] - std::exp(-0.7)) <= 1e-8);
}

TEST_CASE("radau from rest: the unit of time changes no bit") {
  // v = 0 has no size to measure the first correction of v by.
  using One = Eigen::Matrix<double, 1, 1>;
  for (const int stages : {3, 5, 7}) {
    double r = 0, v = 0;
    for (const int exponent : {0, -40, -20, -8, 8, 20, 40}) {
      const double per = std::ldexp(1.0, exponent);
      phistep::Motion<One> y{One{1}, One{0}};
      phistep::PhiStepper stepper{y, [per](const One& at) -> One { return One{-per * per * std::sin(at[0])}; },
                                  phistep::radau(stages)};
      CAPTURE(stages, exponent);
      REQUIRE(stepper.step(y, 0, 1.5 / per));
      if (exponent == 0) r = y.r[0], v = y.v[0];
      CHECK(y.r[0] == r);
      CHECK(y.v[0] / per == v);
    }
  }
}
