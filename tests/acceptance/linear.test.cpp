// What one step does to y' = λy is known exactly: R(z) = (1 + (1−φ)z)/(1−φz), z = λΔt, in either form. The named
// schemes, and a rod: linear.full.cpp.
#include "acceptance/linear_cases.hpp"

#include <complex>

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
