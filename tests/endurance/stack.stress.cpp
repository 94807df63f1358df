// A pyramid of grains on a floor, held together by nothing but friction, for a million steps and more: it must not creep,
// heat up, spread or sink. symplectic_euler, springs of friction that remember.
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "endurance/drift.hpp"
#include "problems/pyramid.hpp"
#include "support/catch.hpp"

namespace {

constexpr double u = 0x1p-53;

void stands(const std::string& name, double tilt) {
  using problems::Pyramid;
  const Pyramid scene{.side = 4, .tilt = tilt};
  auto y = scene.start();
  // Nudged, so that it isn't symmetric.
  std::mt19937_64 random{1};
  std::uniform_real_distribution<double> nudge{-1e-3, 1e-3};
  for (double& v : y.v.reshaped()) v = nudge(random);
  phistep::PhiStepper stepper{y, scene.force(), phistep::symplectic_euler};
  const double h = scene.dt();
  const auto go = [&](double from, double to) {
    const auto report = phistep::integrate(stepper, y, {from * h, to * h}, phistep::fixed(h));
    if (!report) FAIL(report.message());
  };
  const auto kinetic = [&] { return scene.kinetic_energy(y) / (Pyramid::gravity * y.mass().sum() * Pyramid::radius); };
  const double settled = 200000, steps = 2000000;
  go(0, settled);
  const auto rest = y;
  const double height = scene.height(y), after_settling = kinetic();
  const auto series = endurance::follow(
      {name + ", kinetic energy", name + ", height", name + ", creep"}, static_cast<std::int64_t>(steps),
      [&](std::int64_t from, std::int64_t to) {
        go(settled + static_cast<double>(from), settled + static_cast<double>(to));
      },
      [&] {
        return std::array{kinetic(), (scene.height(y) - height) / Pyramid::radius,
                          (y.r - rest.r).colwise().norm().maxCoeff() / Pyramid::radius};
      });
  const std::string which = figures::text(steps) + " steps: ";
  figures::told(scene.deepest(rest) / Pyramid::radius, name, "largest overlap [R]");
  figures::told(after_settling, name, "settled: kinetic energy [weight R]");
  // It still stands: the top grain is where it was put, to the overlaps.
  figures::at_most(0.01, std::abs(y.r.row(2).maxCoeff() - scene.start().r.row(2).maxCoeff()) / Pyramid::radius,
                   name + " stands", which + "the top sank by [R]");
  // At rest is what moves a grain by less than a rounding a step.
  const double speed = 8 * u * 2 / h;
  figures::at_most(static_cast<double>(y.size()) * speed * speed / 2, series[0].worst(), name + " stays cold",
                   which + "kinetic energy [weight R]");
  // A rounding of the position, once, not one a step.
  figures::at_most(32 * u, series[1].worst(), name + " does not sink", which + "mean height [R]");
  figures::at_most(32 * u, series[2].worst(), name + " does not creep", which + "farthest moved [R]");
}

}  // namespace

TEST_CASE("a pyramid of thirty grains, nudged, stands for 2e6 steps: no creep, no heat, no sinking") {
  stands("pyramid", 0);
}

TEST_CASE("on a slope it hangs on by friction, as long") { stands("pyramid on a slope", 0.05); }
