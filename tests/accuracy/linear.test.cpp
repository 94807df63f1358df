// What one step does to y' = λy is known exactly: R(z) = (1 + (1−φ)z)/(1−φz), z = λΔt, in either form. The named
// schemes, and a rod: the full tier.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <vector>

#include "accuracy/observed_order.hpp"
#include "problems/dahlquist.hpp"
#include "problems/march.hpp"
#include "problems/prothero_robinson.hpp"
#include "problems/show_digits.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"
#if PHISTEP_FULL
#include <phistep/sparse.hpp>

#include "problems/heat.hpp"
#endif

using problems::amplification;
using problems::Dahlquist;
using problems::march;

namespace {

constexpr double u = std::numeric_limits<double>::epsilon() / 2;  // unit round-off
const std::vector<double> phis{0, 0.25, 0.5, 0.7, 0.9, 1};

/// Calls f(scheme, φ) with both forms of one φ after the other.
template <class F>
void for_each_phi(F&& f) {
  for (const double phi : phis) {
    f(phistep::phi(phi), phi);
    f(phistep::phi_stage(phi), phi);
  }
}

/// One step of Δt = 1 from y = 1, with the given Jacobian or one by differences.
template <bool given_jacobian>
double one_step(double z, auto scheme) {
  Dahlquist::State y{1};
  if constexpr (given_jacobian) {
    phistep::PhiStepper stepper{y, Dahlquist{z}, scheme};
    problems::step(stepper, y, 0.0, 1.0);
  } else {
    const shared_force::OfState<Dahlquist::State> force = [z](const Dahlquist::State& x) -> Dahlquist::State {
      return z * x;
    };
    phistep::PhiStepper stepper{y, force, scheme};
    problems::step(stepper, y, 0.0, 1.0);
  }
  return y[0];
}

/// A hundred steps from y = 1: run() gives y.
[[maybe_unused]] void check_hundred_steps(double z, double phi, const std::function<double()>& run) {
  constexpr int n = 100;
  const long double R = amplification<long double>(z, phi);
  // Elsewhere the power itself is ill-conditioned, overflows or underflows.
  if (std::abs(R) < 0.1L || std::abs(R) > 100 || std::abs(1 - phi * z) < 0.1) return;
  const double expected = static_cast<double>(std::pow(R, n));
  const double relative = std::abs(run() / expected - 1);
  CAPTURE(z, phi, relative);
  // Each step rounds y and the increment (R−1)y, a few u of each.
  CHECK(relative <= 4 * n * u * (1 + static_cast<double>(std::abs(R - 1) / std::abs(R))));
}
double hundred_steps(double z, auto scheme) {
  Dahlquist::State y{1};
  phistep::PhiStepper stepper{y, Dahlquist{z}, scheme};
  return march(stepper, y, 0.0, 100.0, 100)[0];
}

/// One step of z with a Jacobian and one without.
[[maybe_unused]] void check_one_step(double z, double phi, double given_jacobian, double by_differences) {
  const long double R = amplification<long double>(z, phi);
  const long double condition = 1 + std::abs(phi * z) / std::abs(1 - static_cast<long double>(phi) * z);
  const double bound = static_cast<double>(4 * u * std::max(1.0L, std::abs(R)) * condition);
  const double given = static_cast<double>(std::abs(given_jacobian - R));
  const double differences = static_cast<double>(std::abs(by_differences - R));
  CAPTURE(z, phi, bound, given, differences);
  CHECK(given <= bound);
  CHECK(differences <= bound);
}

}  // namespace

namespace {

/// The largest error over the steps, and the one at t = 1.
struct Errors {
  double largest = 0, last = 0;
};
Errors prothero_robinson(auto scheme, int n) {
  const problems::ProtheroRobinson problem;
  auto y = problem.exact(0);
  phistep::PhiStepper stepper{y, problem, scheme};
  Errors errors;
  for (int k = 0; k < n; ++k) {
    problems::step(stepper, y, k * (1.0 / n), 1.0 / n);
    errors.last = std::abs(y[0] - problem.exact((k + 1.0) / n)[0]);
    errors.largest = std::max(errors.largest, errors.last);
  }
  return errors;
}

}  // namespace

#if PHISTEP_QUICK

TEST_CASE("Dahlquist: a hundred steps multiply y by R^100") {
  for (const double z : {-9.5, -4.0, -1.99, -1.0, -0.3, -1e-2, -1e-5, 1e-3, 0.4, 0.8, 3.0, 7.0})
    for_each_phi(
        [z](auto scheme, double phi) { check_hundred_steps(z, phi, [&] { return hundred_steps(z, scheme); }); });
}

TEST_CASE("Dahlquist: one step is R(z) y to rounding for |z| from 1e-12 to 1e12") {
  for (int exponent = -12; exponent <= 12; ++exponent)
    for (const double sign : {-1.0, 1.0})
      for_each_phi([&](auto scheme, double phi) {
        const double z = sign * 1.1 * std::pow(10.0, exponent);
        check_one_step(z, phi, one_step<true>(z, scheme), one_step<false>(z, scheme));
      });
}

TEST_CASE("complex Dahlquist: a step shrinks y exactly inside the disk of stability") {
  // |R| ≤ 1 ⇔ 2 Re z + (1−2φ)|z|² ≤ 0; on a 200×200 grid, but for the points nearer to the boundary than rounding.
  for (const double phi : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    int inside = 0, outside = 0, wrong = 0;
    Eigen::Vector2d y{1, 0};
    phistep::PhiStepper stepper{y, problems::ComplexDahlquist{{-1, 0}}, phistep::phi(phi)};
    for (int i = 0; i < 200; ++i)
      for (int k = 0; k < 200; ++k) {
        const std::complex<double> z{-6 + 0.06 * i + 0.003, -6 + 0.06 * k + 0.003};
        const double growth = 2 * z.real() + (1 - 2 * phi) * std::norm(z);
        if (std::abs(growth) < 1e-9 || std::abs(1.0 - phi * z) < 1e-6) continue;
        stepper.force().lambda = z;
        y = {1, 0};
        problems::step(stepper, y, 0.0, 1.0);
        ++(growth < 0 ? inside : outside);
        wrong += (y.norm() < 1) != (growth < 0);
      }
    CAPTURE(phi, inside, outside);
    CHECK(wrong == 0);
    CHECK(inside > 300);
    CHECK(outside > 300);
  }
}

TEST_CASE("backward Euler at z = -1e12 keeps every digit of what little is left") {
  for (const double z : {-1e3, -1e6, -1e12, -1e15}) {
    const double expected = static_cast<double>(1 / (1 - static_cast<long double>(z)));
    CAPTURE(z);
    CHECK(std::abs(one_step<true>(z, phistep::phi(1)) / expected - 1) <= 4 * u);
    CHECK(std::abs(one_step<false>(z, phistep::phi(1)) / expected - 1) <= 4 * u);
    CHECK(std::abs(one_step<true>(z, phistep::phi_stage(1)) / expected - 1) <= 4 * u);
  }
}

TEST_CASE("Prothero-Robinson, lambda = -1e6: the trapezoidal rule is of order 2 with an error of h^2/(6|lambda|)") {
  const auto errors = convergence::errors(20, [](int n) { return prothero_robinson(phistep::trapezoidal, n).last; });
  CHECK(errors[0] < 1e-9);
  convergence::check_order(errors, 2);
}

#elif PHISTEP_FULL
// One step of y' = λy by every named scheme too, and a rod's modes.

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

#endif
