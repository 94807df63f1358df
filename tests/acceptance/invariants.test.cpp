// What a scheme keeps for ever: momenta, symplecticity, a bounded energy error. Every scheme: invariants.full.cpp.
#include "acceptance/invariants_cases.hpp"

#include "problems/argon.hpp"

using problems::Argon;

TEST_CASE("Kepler: midpoint and Verlet keep the angular momentum to 1e-12 over 1e5 steps") {
  // A random walk of 1e5 roundings of 1e-16 is 3e-14.
  CHECK(angular_momentum_error(phistep::midpoint, 100000) <= 1e-12);
  CHECK(angular_momentum_error(phistep::velocity_verlet, 100000) <= 1e-12);
}

TEMPLATE_TEST_CASE_SIG("spring net: every phi keeps the linear momentum", "", ((bool damped), damped), false) {
  check_momentum(SpringNet::elastic(), phistep::velocity_verlet, 0.02);
}

TEST_CASE("midpoint, Verlet and symplectic Euler are symplectic, the trapezoidal rule is not") {
  CHECK(symplecticity_defect(phistep::midpoint) <= 1e-7);
  CHECK(symplecticity_defect(phistep::velocity_verlet) <= 1e-7);
  CHECK(symplecticity_defect(phistep::trapezoidal) > 1e-4);
}

TEST_CASE("argon: Verlet's energy error is that of the textbook crystal, and falls as h^2") {
  // max |H − H₀|/k_B over 0.02 ns. Longer runs are chaotic: a shift of 1e-15 moves them.
  const auto energy_error = [](int steps) {
    constexpr double end = 0.02;  // [ns]
    Argon::State y = Argon::start();
    phistep::PhiStepper stepper{y, Argon{}, phistep::velocity_verlet, phistep::mass(Argon::mass)};
    const double start = Argon::energy(y), h = end / steps;
    double worst = 0;
    for (int n = 0; n < steps; ++n) {
      problems::step(stepper, y, n * h, h);
      worst = std::max(worst, std::abs(Argon::energy(y) - start));
    }
    return worst;
  };
  CHECK(Argon::energy(Argon::start()) == Approx(-1260.2066229194).epsilon(1e-12));
  const double at_40_fs = energy_error(500), at_20_fs = energy_error(1000);
  // The digits given are what is known: half a unit of the last one.
  CHECK(std::abs(at_40_fs - 1.5898) <= 0.5e-4);
  CHECK(std::abs(at_20_fs - 0.4206) <= 0.5e-4);
  CHECK(std::abs(at_40_fs / at_20_fs - 3.780) <= 0.5e-3);
}
