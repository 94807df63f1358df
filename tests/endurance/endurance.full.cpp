// What the long programs of this folder show: every rounding of an oscillator, and a heap of grains. The quick half:
// endurance.test.cpp.
#include "endurance/endurance_cases.hpp"

#include <phistep/particles.hpp>

#include "problems/pyramid.hpp"

TEST_CASE("an affine oscillator at phi = 1/2: a million steps, a random walk") {
  check_energy(0.1, phistep::midpoint);
  check_energy(3.0, phistep::trapezoidal);
  check_energy(30.0, phistep::midpoint);
  check_energy(3.0F, phistep::midpoint);
}

TEST_CASE("a pyramid of grains stands by friction, and does not move by a bit more than one rounding") {
  using problems::Pyramid;
  const Pyramid scene{.side = 2, .tilt = 0.05};
  auto y = scene.start();
  phistep::PhiStepper stepper{y, scene.force(), phistep::symplectic_euler};
  const double h = Pyramid::dt();
  REQUIRE(phistep::integrate(stepper, y, {0.0, 1e5 * h}, phistep::fixed(h)));
  const auto rest = y;
  REQUIRE(phistep::integrate(stepper, y, {1e5 * h, 2e5 * h}, phistep::fixed(h)));
  CHECK((y.r - rest.r).cwiseAbs().maxCoeff() <= 0x1p-50);
  CHECK(y.v.cwiseAbs().maxCoeff() * h <= 0x1p-50);
  CHECK(y.r.row(2).maxCoeff() == Approx(scene.start().r.row(2).maxCoeff()).epsilon(0.01));
}
