/// @file
/// What is skipped, switched on and off: grains that came to rest on a floor, left alone or hit by one that falls.
#include <phistep/phistep.hpp>

#include <phistep/contacts/contact.hpp>
#include <phistep/contacts/walls.hpp>
#include <phistep/particles.hpp>

#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

#include "rows.hpp"

namespace bench {
namespace {
using Grains = phistep::Particles<double, 3, phistep::Spin>;
constexpr double dt = 2e-3;    // a contact lasts π √(m*/k) ≈ 11 of them
constexpr double slow = 2e-3;  // as after a fall by 2e-6 diameters

auto bed_force() {
  const phistep::Hooke law{.stiffness = 1e4, .restitution = 0.3, .friction = 0.5, .rolling_friction = 0.1};
  return phistep::Gravity{Eigen::Vector3d{0, 0, -1}} + phistep::Contact{law} +
         phistep::Walls{phistep::Materials{law}, phistep::Plane<3>{{0, 0, 0}, {0, 0, 1}}};
}

/// Unit grains in a loose lattice above a floor, side × side × layers of them, periodic to the sides.
Grains loose(int side, int layers) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shake(-0.04, 0.04);
  Eigen::Matrix3Xd r(3, side * side * layers);
  Eigen::Index n = 0;
  for (int z = 0; z < layers; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x, ++n) {
        r.col(n) << 1.1 * x, 1.1 * y, 0.6 + 1.1 * z;
        for (double& component : r.col(n)) component += shake(random);
      }
  Grains grains{r};
  grains.set_radius(0.5);
  auto box = phistep::Box<double, 3>::periodic({0, 0, 0}, {1.1 * side, 1.1 * side, 1});
  box.is_periodic[2] = false;
  grains.set_box(box);
  return grains;
}

struct Result {
  Grains grains;
  double seconds = 0;
  phistep::SleepReport report{};
};
Result run(const Grains& start, int steps, double speed, int threads) {
  use_threads(threads);
  Result result{start};
  phistep::Sleeping stepper{phistep::PhiStepper{result.grains, bed_force(), phistep::symplectic_euler},
                            phistep::SleepOptions{.speed = speed}};
  const Stopwatch watch(threads);
  for (int n = 0; n < steps; ++n)
    if (const auto report = stepper.step(result.grains, n * dt, dt); !report)
      throw std::runtime_error(report.message());
  result.seconds = watch.seconds();
  result.report = stepper.report();
  return result;
}
}  // namespace

void skipping(const Options& options, Table& table) {
  const int side = options.is_short ? 6 : 16, layers = options.is_short ? 3 : 10, steps = options.is_short ? 200 : 3000;

  const Grains settled = run(loose(side, layers), options.is_short ? 2000 : 10000, 0, 1).grains;
  const double n = static_cast<double>(settled.size());
  std::printf("  settled: kinetic energy %.1e a grain\n", settled.v.squaredNorm() / (2 * n));
  Grains one{Eigen::Matrix3Xd::Constant(3, 1, 0.55 * side)};
  one.r(2, 0) = settled.r.row(2).maxCoeff() + 2;
  one.set_radius(0.5).set_box(settled.box());
  Grains hit = settled;
  hit.add(one);
  for (const auto& [name, start] :
       {std::pair<std::string, const Grains*>{"left alone", &settled}, {"hit by one", &hit}}) {
    const Result on = run(*start, steps, slow, 1), off = run(*start, steps, 0, 1);
    const auto height = [](const Grains& g) { return g.r.row(2).mean(); };
    std::printf(
        "  %s: %lld of %td asleep, %.1f %% of the particle-steps skipped; energy removed %.1e; mean height %.9f, "
        "without sleep %.9f\n",
        name.c_str(), static_cast<long long>(on.report.asleep), start->size(),
        100 * static_cast<double>(on.report.skipped) / (static_cast<double>(start->size()) * steps),
        on.report.energy_removed, height(on.grains), height(off.grains));
    std::vector<Entrant> entrants;
    for (int threads = 1; threads <= options.threads; threads *= 2)
      for (const bool sleeps : {false, true})
        entrants.push_back(
            {name + (sleeps ? ", sleeping" : ", all awake"),
             [from = start, steps, sleeps, threads] { return run(*from, steps, sleeps ? slow : 0, threads).seconds; },
             threads});
    take_turns(entrants, options.rounds);
    table.rates("skipping", start->size(), n * steps, "M grain-steps/s", entrants, {name + ", all awake"});
  }
}

}  // namespace bench
