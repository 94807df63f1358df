// One step of y' = λy by every named scheme too, and a rod's modes. The quick half: linear.test.cpp.
#include <phistep/sparse.hpp>

#include "acceptance/linear_cases.hpp"

#include "problems/heat.hpp"

namespace {

/// The named schemes too, each a type of its own.
template <class F>
void for_each_scheme(F&& f) {
  for_each_phi(f);
  f(phistep::forward_euler, 0.0);
  f(phistep::trapezoidal, 0.5);
  f(phistep::midpoint, 0.5);
  f(phistep::backward_euler, 1.0);
}

}  // namespace

TEST_CASE("Dahlquist: a hundred steps multiply y by R^100") {
  for (const double z : {-9.5, -4.0, -1.99, -1.0, -0.3, -1e-2, -1e-5, 1e-3, 0.4, 0.8, 3.0, 7.0})
    for_each_scheme(
        [z](auto scheme, double phi) { check_hundred_steps(z, phi, [&] { return hundred_steps(z, scheme); }); });
}

TEST_CASE("Dahlquist: one step is R(z) y to rounding for |z| from 1e-12 to 1e12") {
  for (int exponent = -12; exponent <= 12; ++exponent)
    for (const double sign : {-1.0, 1.0})
      for_each_scheme([&](auto scheme, double phi) {
        const double z = sign * 1.1 * std::pow(10.0, exponent);
        check_one_step(z, phi, one_step<true>(z, scheme), one_step<false>(z, scheme));
      });
}

TEST_CASE("backward Euler at z = -1e12 keeps every digit of what little is left") {
  for (const double z : {-1e3, -1e6, -1e12, -1e15}) {
    const double expected = static_cast<double>(1 / (1 - static_cast<long double>(z)));
    CAPTURE(z);
    CHECK(std::abs(one_step<true>(z, phistep::backward_euler) / expected - 1) <= 4 * u);
    CHECK(std::abs(one_step<false>(z, phistep::phi(1)) / expected - 1) <= 4 * u);
    CHECK(std::abs(one_step<true>(z, phistep::phi_stage(1)) / expected - 1) <= 4 * u);
  }
}

TEST_CASE("phi = 1/2 on a very stiff decay alternates: |R + 1| < 5/|z|") {
  const auto check = [](auto scheme) {
    for (const double z : {-1e2, -1e4, -1e6, -1e8, -1e10, -1e12}) {
      Dahlquist::State y{1};
      phistep::PhiStepper stepper{y, Dahlquist{z}, scheme};
      for (int n = 0; n < 10; ++n) {
        const double before = y[0];
        problems::step(stepper, y, static_cast<double>(n), 1.0);
        CAPTURE(z, n);
        CHECK(std::abs(y[0] / before + 1) < 5 / std::abs(z));
      }
    }
  };
  check(phistep::trapezoidal);
  check(phistep::midpoint);
}

TEST_CASE(
    "Prothero-Robinson, lambda = -1e6: the midpoint rule is of order 2, but with a constant that ignores lambda") {
  const auto at_20 = prothero_robinson(phistep::midpoint, 20);
  CHECK(at_20.largest == Approx(6.3e-4).epsilon(0.1));  // h²/4 · max|cos''|
  CHECK(at_20.last == Approx(1.4e-4).epsilon(0.1));
  convergence::check_order(
      convergence::errors(20, [](int n) { return prothero_robinson(phistep::midpoint, n).largest; }), 2);
}

TEMPLATE_TEST_CASE("heat: every mode decays by its exact factor", "", Eigen::MatrixXd, Eigen::SparseMatrix<double>) {
  constexpr int n = 50, steps = 20;
  const problems::Heat<TestType> heat{n};
  const auto check = [&](auto scheme, double phi, double dt) {
    for (const int j : {1, 2, 7, 25, 50}) {
      const Eigen::VectorXd start = heat.mode(n, j);
      const double R = static_cast<double>(amplification<long double>(dt * heat.eigenvalue(n, j), phi));
      phistep::PhiStepper stepper{start, heat, scheme};
      const Eigen::VectorXd u_end = march(stepper, start, 0.0, steps * dt, steps);
      const double error = (u_end - std::pow(R, steps) * start).norm() / start.norm();
      CAPTURE(phi, dt, j, R, error);
      CHECK(error <= 1e-12);
    }
  };
  check(phistep::trapezoidal, 0.5, 1e-2);
  check(phistep::backward_euler, 1, 1e-2);
  check(phistep::phi(0.7), 0.7, 1e-2);
  check(phistep::midpoint, 0.5, 1e-2);
  check(phistep::phi_stage(0.7), 0.7, 1e-2);
  check(phistep::forward_euler, 0, 1.9e-4);  // stable up to 2/|λ| = 1.92e-4
}

TEST_CASE("heat: step data, two backward Euler half steps and then the trapezoidal rule: order 2") {
  constexpr int n = 200;
  const problems::Heat<Eigen::SparseMatrix<double>> heat{n};
  Eigen::VectorXd start(n), coefficient(n);
  for (int i = 0; i < n; ++i) start[i] = i < n / 2 ? 1 : 0;
  // The exact solution of the differences at t = 0.1, mode by mode.
  constexpr double end = 0.1;
  Eigen::VectorXd exact = Eigen::VectorXd::Zero(n);
  for (int j = 1; j <= n; ++j) {
    const Eigen::VectorXd mode = heat.mode(n, j);
    exact += mode.dot(start) / mode.squaredNorm() * std::exp(heat.eigenvalue(n, j) * end) * mode;
  }
  const auto error = [&](int steps, bool damped) {
    const double dt = end / steps;
    phistep::PhiStepper first{start, heat, phistep::backward_euler};
    phistep::PhiStepper rest{start, heat, phistep::trapezoidal};
    Eigen::VectorXd y = start;
    if (damped) {
      y = march(first, y, 0.0, dt, 2);
      y = march(rest, y, dt, end, steps - 1);
    } else {
      y = march(rest, y, 0.0, end, steps);
    }
    return (y - exact).norm() / std::sqrt(double{n});
  };
  convergence::check_order(convergence::errors(20, [&](int steps) { return error(steps, true); }), 2, 0.1);
  CHECK(error(20, false) > 50 * error(20, true));  // the trapezoidal rule alone keeps ringing
}
