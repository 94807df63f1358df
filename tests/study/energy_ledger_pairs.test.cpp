#include <phistep/integrate.hpp>
#include <phistep/particles.hpp>

#include <Eigen/Core>

#include <cmath>

#include "support/catch.hpp"

using namespace phistep;

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
