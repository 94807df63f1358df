// Particles, restarted anywhere: neighbour lists, histories and sleepers go on as they would have.
#include <phistep/particles.hpp>

#include <cmath>
#include <random>

#include "contract/restart.hpp"

using namespace phistep;
using restart::check;
using restart::Steps;
using Atoms = Particles<double, 3>;

namespace {

/// A hot gas, periodic: lists are made every few steps.
Atoms gas() {
  constexpr int n = 3;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Eigen::Matrix3Xd r(3, n * n * n), v(3, n * n * n);
  for (Index k = 0; k < r.cols(); ++k) {
    r.col(k) << 1.3 * static_cast<double>(k % n), 1.3 * static_cast<double>(k / n % n),
        1.3 * static_cast<double>(k / (n * n));
    for (int a = 0; a < 3; ++a) v(a, k) = 2 * normal(random);
  }
  Atoms atoms{r, v};
  atoms.set_mass(2.0).set_box(Box<double, 3>::periodic({0, 0, 0}, {1.3 * n, 1.3 * n, 1.3 * n}));
  return atoms;
}
auto lennard_jones() { return Pairs{LennardJones{}, 1.8, {.skin = 0.2}}; }
template <class... More>
auto steps(auto force, More... more) {
  return [=](const Atoms& y) { return PhiStepper{y, force, more...}; };
}

}  // namespace

TEST_CASE("neighbour lists come back as they were") {
  check({.dt = 0.005, .count = 120}, gas, steps(lennard_jones(), velocity_verlet));
  check({.dt = 0.005, .even = false}, gas, steps(lennard_jones() + LinearDrag{0.1}, velocity_verlet));
  check({.dt = 0.005}, gas, steps(lennard_jones(), trapezoidal));
  check({.dt = 0.005, .even = false}, gas,
        steps(lennard_jones(), backward_euler, newton({.rtol = 1e-4, .atol = 1e-6})));
}
