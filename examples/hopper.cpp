// Sand is poured into a hopper and runs out of the slot at its bottom: 20,000 grains with friction, rolling resistance and
// spin. Layers of grains are added above while it pours, those that have left are erased; contacts keep their friction's
// history through both.
//
// The hopper is a wedge of two slabs at 45°, between two upright planes, and periodic along the slot, as if it were long.
// Sand doesn't run out as water does: the rate doesn't depend on how much lies above, because the walls carry that. Beverloo's
// law for a slot of width D and length L (Nedderman, Statics and Kinematics of Granular Materials, 1992, ch. 10) is
// W = 1.03 ρ_b √g L (D − 1.4 d)^(3/2), with ρ_b the density of the bed and d the grains' diameter.
//
// What comes to rest falls asleep, and the report at the end tells what that saved and cost: nothing, where all flows.
// --sleep 0 computes what is at rest as well.
//
// Run: hopper [--short] [--out DIR] [--grains GRAINS] [--sleep MM_PER_S]
// Frames: hopper.xyz opens in OVITO and ASE                   Picture: python3 plot/plot_hopper.py [DIR]
#include <phistep/io.hpp>
#include <phistep/particles.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <numbers>
#include <random>

#include "command_line.hpp"
#include "progress.hpp"

using Grains = phistep::Particles<double, 3, phistep::Spin>;
using Eigen::Vector3d;
constexpr double d = 4e-3, density = 2500, g = 9.81;  // [m], [kg/m³], [m/s²]: glass beads

struct Hopper {
  double slot, width, length, height;  // [m]: D, between the upright planes, L, where the pouring starts

  [[nodiscard]] std::vector<phistep::Wall<3>> walls() const {
    std::vector<phistep::Wall<3>> all;
    for (const double side : {-1.0, 1.0}) {
      all.push_back(phistep::Plane<3>{{side * width / 2, 0, 0}, {-side, 0, 0}});
      // A slab along the line up from the slot's edge: u along it, n out of it, towards the sand.
      const Vector3d u = Vector3d(side, 0, 1).normalized(), n = Vector3d(-side, 0, 1).normalized();
      const double half = width / std::numbers::sqrt2 / 2, thick = 2 * d;
      phistep::SolidBox<3> slab{Vector3d(side * slot / 2, length / 2, 0) + half * u - thick * n,
                                {half, 10 * length, thick}};
      slab.axes << u, Vector3d::UnitY(), n;
      all.push_back(slab);
    }
    return all;
  }
  /// A layer of grains of d ± 10 %, on a jittered grid, on their way down.
  [[nodiscard]] Grains layer(auto& random) const {
    std::uniform_real_distribution<double> within(-1, 1);
    const double pitch = 1.25 * d;
    const auto columns = long(0.6 * width / pitch), rows = long(length / pitch);
    Eigen::Matrix3Xd r(3, columns * rows), v(3, columns * rows);
    Eigen::VectorXd radius(columns * rows);
    for (long k = 0; k < columns * rows; ++k) {
      radius[k] = d / 2 * (1 + 0.1 * within(random));
      r.col(k) << (double(k % columns) + 0.5 - 0.5 * double(columns)) * pitch,
          (double(k / columns) + 0.5) * length / double(rows), height;
      for (double& x : r.col(k)) x += 0.07 * d * within(random);
      v.col(k) = Vector3d(0.05 * within(random), 0.05 * within(random), -1);
    }
    Grains grains{r, v};
    grains.set_radius(radius).set_mass(density * 4 / 3 * std::numbers::pi * radius.array().cube().matrix());
    return grains;
  }
};

int main(int argc, char** argv) {
  CommandLine options(argc, argv, {{"--grains", ""}, {"--sleep", ""}});
  const auto all = options.whole("--grains", options.is_short ? 400 : 20000, 1);
  const Hopper hopper = options.is_short ? Hopper{5 * d, 20 * d, 4 * d, 14 * d} : Hopper{8 * d, 60 * d, 10 * d, 45 * d};
  const double pause = 0.01, t1 = options.is_short ? 0.25 : 2.8;  // [s] between layers; at most

  const phistep::Hooke glass{.stiffness = 500, .restitution = 0.8, .friction = 0.5, .rolling_friction = 0.05};  // [N/m]
  const double mass = density * std::numbers::pi / 6 * d * d * d;
  const double contact_time = std::numbers::pi * std::sqrt(mass / 2 / glass.stiffness);
  const double dt = pause / std::ceil(pause / (contact_time / 11));

  std::mt19937_64 random(1);
  Grains grains = hopper.layer(random);
  phistep::Box<double, 3> box{{-hopper.width / 2, 0, -20 * d}, {hopper.width / 2, hopper.length, hopper.height}, {}};
  box.is_periodic = {false, true, false};
  grains.set_box(box);
  // Falling grains would have the pairs found anew at nearly every step, were only those just about to touch kept.
  const auto force =
      phistep::Gravity{Vector3d{0, 0, -g}} + phistep::Contact{glass, 0.6 * d} + phistep::Walls{glass, hopper.walls()};
  phistep::Sleeping stepper{phistep::PhiStepper{grains, force, phistep::symplectic_euler},
                            phistep::SleepOptions{.speed = 1e-3 * double(options.whole("--sleep", 2, 0))}};

  auto curves = options.file("hopper.csv"), frames = options.file("hopper.xyz");
  curves << "t_s,inside,left,kinetic_energy_J,coordination\n";
  auto write_frame = phistep::every(options.is_short ? 0.05 : 0.2, phistep::extended_xyz(frames, {.species = {"Si"}}));
  auto bar = progress(t1);
  std::printf("contacts last %.2g ms, steps of %.3g ms\n", 1e3 * contact_time, 1e3 * dt);

  long poured = grains.size(), left = 0;
  double t = 0, grain_steps = 0;
  const std::clock_t began = std::clock();
  for (; t < t1 - pause / 2 && grains.size() > 0; t += pause) {
    const auto report = phistep::integrate(stepper, grains, {t, t + pause}, phistep::fixed(dt), bar);
    if (!report) CommandLine::stop(report.message());
    grain_steps += double(grains.size()) * double(report.statistics.steps);
    const auto& contact = std::get<1>(stepper.force_to_look_at().terms).statistics();
    write_frame(t + pause, grains);
    left += grains.erase_if([&](Eigen::Index i) { return grains.r(2, i) < -15 * d; });
    curves << t + pause << ',' << grains.size() << ',' << left << ',' << phistep::kinetic_energy(grains) << ','
           << 2 * double(contact.touching) / std::max(1.0, double(grains.size())) << '\n';
    if (poured >= all) continue;
    const Grains more = hopper.layer(random);
    grains.add(more);
    poured += more.size();
  }
  const double seconds = double(std::clock() - began) / CLOCKS_PER_SEC;
  std::printf("\n%ld grains were poured, %ld left, after %.2f s. %.2f million grain-steps/s.\n", poured, left, t,
              1e-6 * grain_steps / seconds);
  std::cout << stepper.report();
  return left > 0 ? 0 : 1;
}
