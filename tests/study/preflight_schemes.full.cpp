// preflight, the full list of schemes. In short: preflight.test.cpp.
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
