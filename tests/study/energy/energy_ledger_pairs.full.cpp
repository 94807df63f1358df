#include <phistep/integrate.hpp>
#include <phistep/particles.hpp>

#include <Eigen/Core>

#include <cmath>

#include "support/catch.hpp"

using namespace phistep;

TEST_CASE("bodies held still: their energies are those of their masses, and what carries them does work from outside") {
  for (const double carried : {0.0, 0.5}) {
    Eigen::Matrix3Xd r{{0, 0.3}, {0, 0}, {1, 0}}, v{{carried, 0}, {0, 0}, {0, 0}};
    Particles<double, 3> two{r, v};
    two.set_mass(0.5).set_still({1, 0});
    const auto force = spring_network<3>({{0, 1, 100, 1}}) + Gravity{Eigen::Vector3d{0, 0, -9.81}};
    const double spring = 100 * std::pow((r.col(1) - r.col(0)).norm() - 1, 2) / 2;
    const auto check = [&](auto scheme) {
      auto y = two;
      PhiStepper stepper{y, force, scheme};
      EnergyLedger ledger{stepper};
      CHECK(potential_energy(stepper, y) == Approx(0.5 * 9.81 + spring));
      REQUIRE(integrate(stepper, y, {0, 1}, fixed(0.001), ledger));
      CHECK(ledger.start() == Approx(0.5 * 9.81 + spring + carried * carried / 4));
      CHECK(ledger.kinetic() == Approx(kinetic_energy(y)));
      CHECK(std::abs(ledger.closure()) <= 1e-12);
      CHECK(std::abs(ledger.solver()) <= 1e-12);
      CHECK(std::abs(ledger.external()) >= (carried > 0 ? 0.01 : 0.0));
      if (carried == 0) CHECK(std::abs(ledger.external()) <= 1e-25);
      return ledger.external();
    };
    const double by_verlet = check(velocity_verlet), by_midpoint = check(midpoint), by_half = check(trapezoidal);
    CHECK(by_midpoint == Approx(by_verlet).epsilon(1e-3).margin(1e-12));
    CHECK(by_half == Approx(by_verlet).epsilon(1e-3).margin(1e-12));
  }
}

TEST_CASE("a force with a neighbour list: the ledger closes, and changes no bit of the run") {
  Eigen::Matrix3Xd r(3, 27);
  for (Eigen::Index i = 0; i < 27; ++i)
    r.col(i) = 1.2 * Eigen::Vector3d(double(i % 3), double(i / 3 % 3), double(i / 9)) +
               0.1 * Eigen::Vector3d(std::sin(double(i)), std::cos(double(2 * i)), std::sin(double(3 * i)));
  const auto run = [&](auto watch) {
    Particles<double, 3> atoms{r};
    const Pairs force{LennardJones{}.shifted(1.7), 1.7, {.skin = 0.05}};
    PhiStepper stepper{atoms, force + Gravity{Eigen::Vector3d{0, 0, -0.1}}, velocity_verlet};
    watch(stepper, atoms);
    return atoms.r.eval();
  };
  const auto plain = run([](auto& stepper, auto& atoms) {
    CHECK(integrate(stepper, atoms, {0.0, 1.0}, fixed(0.005)));
  });
  const auto watched = run([](auto& stepper, auto& atoms) {
    EnergyLedger ledger{stepper};
    CHECK(integrate(stepper, atoms, {0.0, 1.0}, fixed(0.005), ledger));
    CHECK(std::abs(ledger.closure()) <= 1e-13 * ledger.largest_energy());
    CHECK(ledger.steps() == 200);
    CHECK(ledger.potential() < 0);
    CHECK(std::abs(ledger.energy() - ledger.start()) < 1e-2 * std::abs(ledger.start()));
    CHECK(std::get<0>(stepper.force_to_look_at().terms).rebuilds() > 1);
  });
  CHECK(plain == watched);
}
