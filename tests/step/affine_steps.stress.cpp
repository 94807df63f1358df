// What affine steps give, kind by kind; the quick half is affine.test.cpp.
#include "step/affine_cases.hpp"

using namespace affine_cases;

TEST_CASE("an affine step gives what Newton to rounding gives") {
  const Mat A = rod(8);
  Mat K = A, C = 0.01 * A;
  K(0, 3) += 40;  // neither symmetric …
  C(2, 1) -= 3;   // … nor the same
  const auto promised = linear(K, C);
  const auto unpromised = [=](const Vec& r, const Vec& v) -> Vec { return K * r + C * v; };
  for (const double phi : {0.25, 0.5, 0.8, 1.0})
    for (const double dt : {1e-6, 1e-3, 0.1, 10.0}) {
      if (phi < 0.5 && dt > 1e-3) continue;  // unstable there
      Y one{Vec::LinSpaced(8, 1, 2), Vec::LinSpaced(8, -1, 3)}, other = one;
      PhiStepper once{one, promised, phistep::phi(phi), mass(2.0)};
      PhiStepper iterated{other, unpromised, phistep::phi(phi), mass(2.0)};
      for (int n = 0; n < 20; ++n) {
        problems::step(once, one, n * dt, dt);
        problems::step(iterated, other, n * dt, dt);
        // Rounding in Ψ, seen through W⁻¹, is some units in the last place of r and of r/Δt.
        const double r = other.r.norm() + dt * other.v.norm();
        CAPTURE(phi, dt, n);
        REQUIRE((one.r - other.r).norm() <= 1e-12 * std::max(r, 1e-3));
        REQUIRE((one.v - other.v).norm() <= 1e-12 * std::max({r / dt, other.v.norm(), 1e-3}));
        one = other;
      }
    }
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
    PhiStepper stepper{y, affine(f), midpoint};
    for (int n = 0; n < 5; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
    on = true;
    const Y before = y;
    Outcome outcome = Outcome::success;
    int n = 5;
    Y last = y;
    for (; n < 8 && outcome == Outcome::success; ++n) {
      last = y;
      outcome = stepper.step(y, n, 0.1).outcome();
    }
    CHECK(outcome == Outcome::not_affine);
    CHECK(n == 8);
    CHECK((y.r.array() == last.r.array()).all());
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
  // φ = ½ and λΔt ≈ −2: b = y + ½λΔt y and y⁺ are next to nothing, and what is left is the rounding of what they cancel.
  using One = Eigen::Matrix<double, 1, 1>;
  for (const double off : {0.0, 1e-12, 1e-9, 1e-6, -1e-9, -1e-4})
    for (const double start : {0.3, 0.7, 1.1}) {
      One z{start};
      const double lambda = -2 * (1 + off);
      PhiStepper decay{z, affine([lambda](const One& x) -> One { return lambda * x; }), trapezoidal};
      CAPTURE(off, start);
      REQUIRE(decay.step(z, 0, 1));
      CHECK(std::abs(z[0] + off / 2 * start) <= 1e-15 + off * off);
      // An overdamped motion, cΔt = 2.
      Motion<One> y{One{0}, One{start}};
      PhiStepper damped{y, linear(Eigen::MatrixXd{{-1e-6}}, Eigen::MatrixXd{{lambda}}), trapezoidal};
      REQUIRE(damped.step(y, 0, 1));
    }
}
