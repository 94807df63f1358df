// A spray of charged drops: they repel one another, a jet of air drags them along and cools them, and a plate catches them.
//
// Hot water drops of 40 to 120 μm leave a nozzle 25 cm above the plate, 60 a millisecond. Drag is Stokes', 6πμR (u − v), cooling
// by conduction, 4πλR (T_air − T): small drops follow the air and are cold when they arrive, large ones are neither. Charges
// (a share of Rayleigh's limit, 8π √(ε₀ γ R³), at which a drop would burst) act between all pairs and open the spray: the
// run is done with and without. A force that also heats is written here, as anybody could. Follows T. I. Zohdi, Introduction
// to the Modeling and Simulation of Particulate Flows (SIAM 2007).
//
// Run: spray [--short] [--out DIR]
// Frames: spray_*.xyz open in OVITO and ASE                   Picture: python3 plot/plot_spray.py [DIR]
#include <phistep/io.hpp>
#include <phistep/particles.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>

#include "command_line.hpp"
#include "progress.hpp"

using Drops = phistep::Particles<double, 3, phistep::Temperature>;
using Eigen::Vector3d;
constexpr double pi = std::numbers::pi;
constexpr double epsilon0 = 8.854e-12, surface_tension = 0.072;                   // [F/m], [N/m]
constexpr double viscosity = 1.8e-5, conductivity = 0.026, air_temperature = 20;  // [Pa s], [W/(m K)], [°C]
constexpr double water = 1000, heat_of_water = 4186, reach = 0.3;  // [kg/m³], [J/(kg K)], [m] to the plate

/// A round jet from a nozzle of 8 mm: 25 m/s at first, then slower and wider as it goes down. [m/s]
Vector3d wind(const auto& r) {
  const double from = 0.048 - r[2], width = 0.1 * from;
  return {0, 0, -25 * std::min(1.0, 0.048 / from) * std::exp(-(r[0] * r[0] + r[1] * r[1]) / (width * width))};
}

/// Drag towards the moving air, and heat lost to it.
struct Air : phistep::ForceTerm {
  static constexpr bool uses_velocity = true, uses_time = false;

  void add(double /*t*/, const auto& y, auto& out) const {
    for (Eigen::Index i = 0; i < y.r.cols(); ++i) {
      const double R = y.body.radius[i];
      out.force.col(i) += 6 * pi * viscosity * R * (wind(y.r.col(i)) - y.v.col(i));
      out.heat[i] += 4 * pi * conductivity * R * (air_temperature - y.temperature[i]);
    }
  }
};

/// Some drops just below the nozzle, in a cone.
Drops drops(Eigen::Index n, double charge, auto& random) {
  std::uniform_real_distribution<double> within(-1, 1);
  Eigen::Matrix3Xd r(3, n), v(3, n);
  Eigen::VectorXd R(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    R[i] = 20e-6 + 20e-6 * (1 + within(random));
    r.col(i) << 3e-3 * within(random), 3e-3 * within(random), -4e-3 * (1 + within(random));
    v.col(i) << within(random), within(random), -15 + 3 * within(random);
  }
  Drops some{r, v};
  const Eigen::VectorXd m = water * 4 / 3 * pi * R.array().cube();
  some.set_radius(R).set_mass(m).set_heat_capacity(heat_of_water * m);
  some.set_charge((charge * 8 * pi * (epsilon0 * surface_tension * R.array().cube()).sqrt()).matrix());
  some.temperature.setConstant(90);
  return some;
}

int main(int argc, char** argv) {
  CommandLine options(argc, argv);
  const double t1 = options.is_short ? 0.01 : 0.1, dt = 1e-4, pause = 1e-3;  // [s]
  auto curves = options.file("spray.csv"), plate = options.file("spray_plate.csv");
  curves << "charge,t_s,flying,landed,kinetic_energy_J,mean_temperature_C\n";
  plate << "charge,t_s,x_m,y_m,radius_m,temperature_C\n";
  bool good = true;
  for (const double charge : {0.0, 0.5}) {
    const std::string name = charge > 0 ? "spray_charged" : "spray_neutral";
    std::mt19937_64 random(1);
    Drops spray = drops(60, charge, random);
    const auto force = phistep::Gravity{Vector3d{0, 0, -9.81}} + Air{} +
                       phistep::AllPairs{phistep::Coulomb{.k = 1 / (4 * pi * epsilon0), .epsilon = 50e-6}};
    phistep::PhiStepper stepper{spray, force, phistep::symplectic_euler};
    auto frames = options.file(name + ".xyz");
    auto write_frame = phistep::every(t1 / 6, phistep::extended_xyz(frames, {.species = {"O"}}));
    auto bar = progress(t1);
    long landed = 0;
    double heat = 0;
    for (double t = 0; t < t1 - pause / 2; t += pause) {
      const auto report = phistep::integrate(stepper, spray, {t, t + pause}, phistep::fixed(dt), bar);
      if (!report) CommandLine::stop(report.message());
      write_frame(t + pause, spray);
      landed += spray.erase_if([&](Eigen::Index i) {
        if (spray.r(2, i) > -reach) return false;
        plate << charge << ',' << t << ',' << spray.r(0, i) << ',' << spray.r(1, i) << ',' << spray.radius()[i] << ','
              << spray.temperature[i] << '\n';
        heat += spray.temperature[i];
        return true;
      });
      curves << charge << ',' << t + pause << ',' << spray.size() << ',' << landed << ','
             << phistep::kinetic_energy(spray) << ',' << spray.temperature.mean() << '\n';
      spray.add(drops(60, charge, random));
    }
    std::printf("\n%s: %ld drops fly, %ld have landed, at %.1f °C on average\n", name.c_str(), long(spray.size()),
                landed, landed > 0 ? heat / double(landed) : NAN);
    good = good && spray.r.allFinite() && spray.temperature.minCoeff() > air_temperature;
  }
  return good ? 0 : 1;
}
