// preflight, the full list of schemes. In short: preflight.test.cpp.
#include <Eigen/Eigenvalues>

#include <complex>

#include "problems/step_matrix.hpp"
#include "study/preflight_cases.hpp"

using namespace preflight_cases;

TEST_CASE("stable at preflight's dt, not at 1.5 times it: motion, other schemes and damping") {
  const auto y = chain_state(300);
  const auto springs = spring_network<1>(chain(300, 300));
  check_scene("chain and drag, velocity_verlet", PhiStepper{y, springs + LinearDrag{3.0}, velocity_verlet, mass(2.0)},
              y);
  check_scene("chain and drag, symplectic_euler",
              PhiStepper{y, springs + LinearDrag{20.0}, symplectic_euler, mass(2.0)}, y);
  check_scene("chain and drag, symplectic_euler_adjoint",
              PhiStepper{y, springs + LinearDrag{20.0}, symplectic_euler_adjoint, mass(2.0)}, y);
  check_scene("chain with dashpots, symplectic_euler",
              PhiStepper{y, spring_network<1>(chain(300, 300), SpringDamping{10}), symplectic_euler, mass(2.0)}, y);
  check_scene("chain, phi(0.2, 0.9)", PhiStepper{y, springs, phi(0.2, 0.9), mass(2.0)}, y);
  check_scene("chain and drag, phi(0.25)", PhiStepper{y, springs + LinearDrag{20.0}, phi(0.25), mass(2.0)}, y);
  const auto few = chain_state(20);
  check_scene("20 particles with dashpots, symplectic_euler",
              PhiStepper{few, spring_network<1>(chain(20, 300), SpringDamping{10}), symplectic_euler, mass(2.0)}, few);
  const Motion oscillator{Eigen::Vector2d{0, 0}, Eigen::Vector2d{0, 0}};
  const auto report =
      check_scene("damped oscillator, forward_euler",
                  PhiStepper{oscillator, linear(Eigen::Matrix2d(-4 * Eigen::Matrix2d::Identity())) + LinearDrag{0.8},
                             forward_euler},
                  oscillator);
  CHECK(report.stable_dt == Approx(0.999 * 0.8 / 4).epsilon(1e-9));  // 2ζ/ω = c/ω²
  check_scene("chain, half of it as kicks, trapezoidal",
              PhiStepper{y, springs + at(forward_euler, spring_network<1>(chain(300, 20))), trapezoidal, mass(2.0)}, y);
}

TEST_CASE("generalized-alpha and Newmark's family by their own roots") {
  // The closed form, and (numerics of Chung & Hulbert) the radius at ωΔt = 0.1, 1, 3, 10 for ρ∞ = ½.
  const Method half = method_of(generalized_alpha(0.5), true);
  for (const auto& [a, radius] : {std::pair{0.1, 0.9999982}, {1.0, 0.9893128}, {3.0, 0.8761329}, {10.0, 0.6825284}})
    CHECK(std::abs(half.oscillation(a)) == Approx(radius).margin(5e-8));
  CHECK(std::abs(half.factor(-1e6)) == Approx(0.5).epsilon(1e-3));
  // Conditionally stable: linear acceleration to √12, Fox and Goodwin's to √6; average acceleration always.
  CHECK(method_of(newmark(1.0 / 6, 0.5), true).oscillation_limit() == Approx(std::sqrt(12)).epsilon(1e-4));
  CHECK(method_of(newmark(1.0 / 12, 0.5), true).oscillation_limit() == Approx(std::sqrt(6)).epsilon(1e-4));
  CHECK(method_of(newmark(0.25, 0.5), true).is_a_stable());
  // A decay of a motion is one by the weights of motions, of which drag alone leaves (1−γ)/γ; of first order, ρ.
  CHECK(method_of(generalized_alpha(0), true).factor(-1e6).real() == Approx(1.0 / 3).epsilon(1e-3));
  CHECK(std::abs(method_of(generalized_alpha(0), false).factor(-1e6)) <= 1e-2);
  CHECK(std::abs(method_of(generalized_alpha(0.5), false).oscillation(1)) ==
        Approx(
            problems::step_matrix(generalized_alpha(0.5), std::complex{0.0, 1.0}).eigenvalues().cwiseAbs().maxCoeff()));
  const auto y = chain_state(300);
  const auto springs = spring_network<1>(chain(300, 300));
  check_scene("chain, newmark(1/6, 1/2)", PhiStepper{y, springs, newmark(1.0 / 6, 0.5), mass(2.0)}, y);
  check_scene("chain and drag, newmark(1/6, 1/2)",
              PhiStepper{y, springs + LinearDrag{0.1}, newmark(1.0 / 6, 0.5), mass(2.0)}, y);
  // What a report says: the scheme with its parameter, and order 2 in place of order 1.
  const Motion two{Eigen::Vector2d{1, 0}, Eigen::Vector2d{0, 0}};
  const auto ask = [&](auto scheme) {
    PhiStepper stepper{two, linear(Eigen::Matrix2d{{-1, 0}, {0, -1e6}}), scheme};
    return preflight(stepper, two, 0.1, {.period = 6.28});
  };
  CHECK(ask(generalized_alpha(0.5)).verdict == Verdict::fine);
  CHECK(ask(generalized_alpha(0.5)).recommended.scheme == "generalized_alpha(0.5)");
  CHECK(ask(hht(-0.1)).recommended.scheme == "hht(-0.1)");
  CHECK(ask(bossak(-0.1)).recommended.scheme == "bossak(-0.1)");
  CHECK(ask(newmark(0.3, 0.5)).recommended.scheme == "newmark(0.3, 0.5)");
  CHECK(ask(from_spectral_radius(0.5))
            .finding.find("generalized_alpha(0.5) damps the fastest modes as much, at order 2") != std::string::npos);
}
