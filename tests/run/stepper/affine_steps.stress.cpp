// What affine steps give, kind by kind; in short: affine.test.cpp.
#include <algorithm>
#include <cmath>

#include "run/stepper/affine_rod.hpp"

using namespace affine_cases;

namespace {
struct WrongSign {
  static constexpr bool is_affine = true;
  Vec operator()(const Vec& r) const { return -r; }
  Mat jacobian(const Vec&) const { return Mat::Identity(3, 3); }
};
}  // namespace

TEST_CASE("an affine step gives what Newton to rounding gives") {
  const Mat A = rod(8);
  Mat K = A, C = 0.01 * A;
  K(0, 3) += 40;  // neither symmetric …
  C(2, 1) -= 3;   // … nor the same
  check_as_newton(K, C, Y{Vec::LinSpaced(8, 1, 2), Vec::LinSpaced(8, -1, 3)});
}

TEST_CASE("a matrix mass does not spoil the Ψ that the one solve starts from") {
  Vec by_matrix = Vec::LinSpaced(8, 1, 2), by_scalar = by_matrix;
  PhiStepper matrix{by_matrix, linear(rod(8)), trapezoidal, capacity(Mat(2 * Mat::Identity(8, 8)))};
  PhiStepper scalar{by_scalar, linear(rod(8)), trapezoidal, capacity(2.0)};
  for (int n = 0; n < 5; ++n) {
    problems::step(matrix, by_matrix, 0.1 * n, 0.1);
    problems::step(scalar, by_scalar, 0.1 * n, 0.1);
  }
  CHECK((by_matrix - by_scalar).norm() <= 1e-14);
}

TEST_CASE("a step of another length makes new factors, whatever the tolerance") {
  Vec exact = Vec::LinSpaced(8, 1, 2), tolerant = exact;
  PhiStepper plain{exact, linear(rod(8)), trapezoidal};
  PhiStepper loose{tolerant, linear(rod(8)), trapezoidal, newton({.rtol = 1e-3, .atol = 1e-6})};
  for (const double dt : {0.1, 0.11, 0.12, 0.1}) {
    problems::step(plain, exact, 0.0, dt);
    problems::step(loose, tolerant, 0.0, dt);
  }
  CHECK((exact.array() == tolerant.array()).all());
  CHECK(plain.statistics().factorizations == 4);
  CHECK(plain.statistics().jacobians == 1);
}

TEST_CASE("the affine step keeps the energy of an oscillator, soft or stiff, for a million steps") {
  using One = Eigen::Matrix<double, 1, 1>;
  const auto drift = [](double a, auto scheme) {
    const auto energy = [a](const Motion<One>& y) { return 0.5L * y.v[0] * y.v[0] + 0.5L * a * a * y.r[0] * y.r[0]; };
    Motion<One> y{One(1), One(0.3 * a)};
    PhiStepper stepper{y, linear(One(-a * a)), scheme};
    const long double start = energy(y);
    long double worst = 0;
    for (int n = 0; n < 1000000; ++n) {
      problems::step(stepper, y, 1.0 * n, 1.0);
      if (n % 100 == 99) worst = std::max(worst, std::abs(energy(y) / start - 1));
    }
    return static_cast<double>(worst);
  };
  // A random walk of a million roundings is 1e-13, one correlated rounding in fifty 5e-12 (a = 1, whose sums tie); of
  // roundings of γv, a/2 times as large, 1e-13 a/2, and three times that is rare. Beyond a = 32 the unknown is a displacement
  // and the rounding in 1/W, always the same, counts twice a step: 2u·1e6 = 2e-10.
  for (const double a : {1e-3, 0.1, 0.3, 1.0, 1.9, 2.1, 3.0, 10.0, 30.0, 1e3, 1e6}) {
    const double limit = a <= 0.3 || (a > 1 && a <= 3) ? 1e-12 : a == 1 ? 1e-11 : a <= 30 ? 3e-13 * a : 2.3e-10;
    CAPTURE(a);
    CHECK(drift(a, trapezoidal) <= limit);
    CHECK(drift(a, midpoint) <= limit);
  }
}

TEST_CASE("backward Euler of an affine force damps z = -1e12 to rounding") {
  Eigen::Matrix<double, 1, 1> y(1.0);
  PhiStepper stepper{y, linear(Eigen::Matrix<double, 1, 1>(-1e12)), backward_euler};
  REQUIRE(stepper.step(y, 0, 1));
  CHECK(std::abs(y[0] - 1 / (1 + 1e12)) <= 4 * 1.2e-16);
}

TEST_CASE("a promise of affinity that is broken is found out, and nothing is lost") {
  Y y{Vec::Ones(3), Vec::Zero(3)};
  const Y start = y;
  SECTION("a nonlinear force") {
    PhiStepper stepper{y, affine([](const Vec& r) -> Vec { return -r.array().sin(); }), trapezoidal};
    const StepReport report = stepper.step(y, 0, 0.01);
    CHECK(report.outcome() == Outcome::not_affine);
    CHECK_THAT(report.message(), Catch::Matchers::Contains("affine"));
  }
  SECTION("a Jacobian with the wrong sign") {
    PhiStepper stepper{y, WrongSign{}, trapezoidal};
    CHECK(stepper.step(y, 0, 0.1).outcome() == Outcome::not_affine);
  }
  SECTION("a force that stops being what it was is found at step 2, 4, 8, …") {
    bool on = false;
    const auto f = [&on](const Vec& r) -> Vec { return on ? Vec(-r - r.cwiseProduct(r)) : Vec(-r); };
    check_change_found(y, affine(f), on);
    return;
  }
  SECTION("a singular matrix, 1 = γ²k") {
    PhiStepper stepper{y, linear(Mat(4 * Mat::Identity(3, 3))), trapezoidal};
    CHECK(stepper.step(y, 0, 1).outcome() == Outcome::singular_matrix);
  }
  CHECK((y.r.array() == start.r.array()).all());
  CHECK((y.v.array() == start.v.array()).all());
}

TEST_CASE("a step that nearly annihilates the state is no broken promise") {
  // An overdamped motion, cΔt = 2; a decay is in the quick half.
  using One = Eigen::Matrix<double, 1, 1>;
  for (const double off : {0.0, 1e-12, 1e-9, 1e-6, -1e-9, -1e-4})
    for (const double start : {0.3, 0.7, 1.1}) {
      const double lambda = -2 * (1 + off);
      CAPTURE(off, start);
      Motion<One> y{One{0}, One{start}};
      PhiStepper damped{y, linear(Eigen::MatrixXd{{-1e-6}}, Eigen::MatrixXd{{lambda}}), trapezoidal};
      REQUIRE(damped.step(y, 0, 1));
    }
}
