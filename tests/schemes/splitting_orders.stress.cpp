// Strang's half kicks: orders and stability by every scheme; in short: splitting.test.cpp.
#include "schemes/splitting_cases.hpp"

using namespace splitting_cases;

TEST_CASE("one step is the formula: half kick, phi-step of the rest, half kick") {
  const double m = 2, h = 0.3, k = 3, e = 0.7;
  Motion<V1> y{V1(0.7), V1(-0.4)};
  const double half_kick = h / 2 * -e * 0.7 / m, v = -0.4 + half_kick, r = 0.7, w = k / m;
  const double v1 = (v - h * w * (r + h / 4 * v)) / (1 + h * h * w / 4), r1 = r + h / 2 * (v + v1);
  PhiStepper stepper{
      y, at(forward_euler, [e](const V1& x) -> V1 { return -e * x; }) + term([k](const V1& x) -> V1 { return -k * x; }),
      trapezoidal, mass(m)};
  problems::step(stepper, y, 0.0, h);
  CHECK(y.r[0] == Approx(r1).epsilon(1e-15));
  CHECK(y.v[0] == Approx(v1 - h / 2 * e * r1 / m).epsilon(1e-15));
}

TEST_CASE("order 2 where the scheme inside is, else 1") {
  const auto split = term(stiff) + at(forward_euler, soft);
  const auto whole = term(stiff) + term(soft);
  check_split_order(start(), split, whole, trapezoidal, 2, 80, 0.05);
  check_split_order(start(), split, whole, midpoint, 2, 80, 0.05);
  check_split_order(start(), split, whole, tr_bdf2, 2, 160, 0.05);
  check_split_order(start(), split, whole, velocity_verlet, 2, 80, 0.05);
  check_split_order(start(), split, whole, backward_euler, 1, 800, 0.05);
  check_split_order(start(), split, whole, phi(0.7), 1, 800, 0.05);
}

TEST_CASE("order 2 with kicks that depend on v and t, and in first order") {
  check_split_order(start(), term(stiff) + at(forward_euler, damped_soft), term(stiff) + term(damped_soft), trapezoidal,
                    2, 80, 0.05);
  const auto flow = [](const V2& y, double t) -> V2 { return {-y[0] * y[0] + y[1], std::sin(3 * t) - y[0] * y[1]}; };
  const auto decay = [](const V2& y) -> V2 { return {-8 * y[0] - y[1], -5 * y[1] - y[1] * y[1] * y[1]}; };
  check_split_order(V2{1, 0.5}, term(decay) + at(forward_euler, flow), term(decay) + term(flow), trapezoidal, 2, 80,
                    0.05);
  check_split_order(V2{1, 0.5}, term(decay) + at(forward_euler, flow), term(decay) + term(flow), backward_euler, 1, 800,
                    0.05);
}

TEST_CASE("stable to dt omega_e = 2, however stiff the rest") {
  for (const double k_s : {0.0, 1e-3, 1.0, 10.0, 1e3, 1e6}) {
    CAPTURE(k_s);
    // The step's matrix has determinant 1: stable means both eigenvalues on the unit circle, up to rounding.
    CHECK(std::abs(spectral_radius(trapezoidal, k_s, 1.99) - 1) <= 1e-13 * std::max(1.0, std::sqrt(k_s)));
    CHECK(std::abs(spectral_radius(midpoint, k_s, 1.99) - 1) <= 1e-13 * std::max(1.0, std::sqrt(k_s)));
    // With Δt = 1, c = k_s/4: half the trace is (1 − c − ω²/2)/(1 + c) = −1 − ε, and ρ = 1 + ε + √(2ε + ε²).
    const double e = (2.01 * 2.01 / 2 - 2) / (1 + k_s / 4), growth = e + std::sqrt(2 * e + e * e);
    CHECK(spectral_radius(trapezoidal, k_s, 2.01) - 1 == Approx(growth).epsilon(1e-6));
  }
}
