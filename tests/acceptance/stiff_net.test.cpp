// A membrane of springs in steps from well below to far above what an explicit scheme could take: every oscillation
// follows the exact map of the scheme (numerical frequency, damping and all), and the cost hardly grows with the
// stiffness. By backward Euler too: stiff_net.full.cpp.
#include "acceptance/stiff_net_cases.hpp"

TEST_CASE("a stiff net follows the scheme's exact map, mode by mode") {
  for (const double k : {1.0, 1e2, 1e4, 1e6, 1e8}) {
    CAPTURE(k);
    // Linear: what is left is rounding. φ = ½ keeps each solve's error for good, and Newton may stop where its corrections
    // are 4e-11 (u^⅔) of the velocity: 20 steps make 8e-10.
    const Result linear = run(trapezoidal, 0.5, k, 0, 1);
    CHECK(linear.error <= 8e-10);
    CHECK(linear.energy_error <= 1.6e-9);
    CHECK(linear.work.fallbacks == 0);
    // Stretched: springs rotate, which adds terms of the order of the squared slope, 1e-8 … a few times, in each step.
    const Result stretched = run(trapezoidal, 0.5, k, 0.8, 1e-5);
    CHECK(stretched.error <= 1e-6);
    CHECK(stretched.energy_error <= 2e-6);
  }
}

TEST_CASE("the cost of a step grows more slowly than the square root of the stiffness") {
  double before = 0;
  for (const double k : {1.0, 1e2, 1e4, 1e6, 1e8}) {
    const double now = run(trapezoidal, 0.5, k, 0, 1).linear_iterations;
    CAPTURE(k, before, now);
    if (before > 0) CHECK(now < 10 * before);  // √100
    before = now;
  }
  // Theory: with Δt²k/m → ∞ the condition number becomes that of the net itself, (2N/π)² = 68, whatever k; each digit then
  // takes some √68/2 · ln 10 = 10 iterations, and the sixteen digits of rounding 160.
  CHECK(before < 250);
}
