// Grains asleep and awake: the same bits with one, two and three threads.
#include <phistep/particles.hpp>
#include <phistep/particles/sleep/sleeping.hpp>

#include <cmath>
#include <tuple>
#include <utility>

#include "support/catch.hpp"
#include "support/threads.hpp"

using namespace phistep;
using Grains = Particles<double, 3, Spin>;
using Eigen::Vector3d;

namespace {

constexpr double dt = 1e-3, g = 9.81, k = 1e4;
constexpr Index nx = 110, ny = 104;

/// Two grains on each other at each point of a lattice, at rest: so many that threads share every pass over all. Three fast
/// ones fly over them, and hit one that lies on top.
constexpr Index fast = 3;
Grains carpet() {
  Grains grains{Eigen::Matrix3Xd(3, 2 * nx * ny + 1 + fast)};
  for (Index i = 0; i < nx * ny; ++i) {
    const auto x = static_cast<double>(i % nx), y = static_cast<double>(i / nx);
    grains.r.col(2 * i) << x, y, 0.5 - 2 * g / k;
    grains.r.col(2 * i + 1) << x, y, 1.5 - 3 * g / k;
  }
  for (Index i = 2 * nx * ny; i < grains.size(); ++i) {
    grains.r.col(i) << 60 - static_cast<double>(i % 4), 50, 2.65;
    grains.v.col(i) << 200, 0, 0;
  }
  grains.r.col(2 * nx * ny) << 70, 50, 2.5 - 3 * g / k;
  grains.v.col(2 * nx * ny).setZero();
  grains.set_mass(1.0).set_radius(0.5);
  return grains;
}

auto run(int threads) {
  const phistep_test::Threads of{threads};
  const Hooke law{.stiffness = k, .restitution = 0.3, .friction = 0.6, .rolling_friction = 0.2};
  Grains grains = carpet();
  Sleeping stepper{PhiStepper{grains,
                              Contact{law} + Walls<Hooke>{law, Plane<3>{Vector3d::Zero(), Vector3d::UnitZ()}} +
                                  Gravity{Vector3d{0, 0, -g}},
                              symplectic_euler},
                   SleepOptions{.speed = 1e-2, .steps = 5, .every = 5}};
  for (int n = 0; n < 50; ++n) {
    if (n == 11) {
      CHECK(stepper.report().asleep > grains.size() - 20);
      for (Index i = 0; i < grains.size(); ++i)
        if (grains.r(0, i) < 20)
          grains.v.col(i) << 0.3 * std::sin(static_cast<double>(i)), 0.3 * std::cos(2 * static_cast<double>(i)), 0;
    }
    REQUIRE(stepper.step(grains, dt * n, dt));
  }
  CHECK(std::get<0>(stepper.force_to_look_at().terms).statistics().late > 20);
  return std::pair{std::move(grains), stepper.report()};
}

}  // namespace

TEST_CASE("sleepers, and those whom a blow wakes, have the same bits with any number of threads") {
  const auto [one, report] = run(1);
  CHECK(report.asleep > 10000);
  CHECK(report.asleep < 18000);  // some ten thousand pairs are computed
  CHECK(report.fell_asleep > 2 * nx * ny);
  for (const int threads : {2, 3}) {
    const auto [several, its] = run(threads);
    CHECK(several.r == one.r);
    CHECK(several.v == one.v);
    CHECK(several.omega == one.omega);
    CHECK(its.asleep == report.asleep);
    CHECK(its.fell_asleep == report.fell_asleep);
    CHECK(its.woken == report.woken);
    CHECK(its.skipped == report.skipped);
    CHECK(its.energy_removed == report.energy_removed);
    CHECK(its.impulse_not_applied == report.impulse_not_applied);
  }
}
