// A pendulum whose rod is a stiff spring: two time scales, two values of φ.
//
// The swing takes 2 s, the rod's own vibration 6 ms. Verlet must follow the vibration, Δt < 2/ω = 2 ms. With φ = ½ for the
// rod and φ = 0 for gravity, `rod + at(forward_euler, gravity)`, gravity enters as half kicks before and after the rod's
// step: Newton sees the rod alone, gravity (a constant) is called once in the whole run, Δt follows the swing, and halving
// it quarters the error. φ = 1 for the rod is stable too, but of order 1, and takes energy out of the swing.
//
// Run: stiff_pendulum [--short] [--out DIR]        Picture: python3 plot/plot_stiff_pendulum.py [DIR]
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "command_line.hpp"

using Vec = Eigen::Vector2d;
using Pendulum = phistep::Motion<Vec>;

constexpr double bob = 1, rod_length = 1, stiffness = 1e6, g = 9.81, t1 = 4;  // [kg] [m] [N/m] [m/s²] [s]

double energy(const Pendulum& y) {
  return 0.5 * bob * y.v.squaredNorm() + bob * g * (y.r.y() + rod_length) +
         0.5 * stiffness * std::pow(y.r.norm() - rod_length, 2);
}
double angle(const Pendulum& y) { return std::atan2(y.r.x(), -y.r.y()); }

/// Released at 60° with the rod as long as gravity makes it.
Pendulum start() {
  const double angle = std::numbers::pi / 3, length = rod_length + bob * g * std::cos(angle) / stiffness;
  return {length * Vec{std::sin(angle), -std::cos(angle)}, Vec{0, 0}};
}

struct Swing {
  double angle, energy_error;  // [rad] at the end; max |E/E0 − 1|
  phistep::Statistics statistics;
};

/// Runs to t1, writing (scheme, Δt, t, energy error) for the picture; NaN where the run blows up.
Swing run(const char* name, const auto& force, auto scheme, double dt, std::ostream* out) {
  Pendulum y = start();
  phistep::PhiStepper stepper{y, force, scheme, phistep::mass(bob)};
  double worst = 0, E0 = energy(y);
  const auto report = phistep::integrate(stepper, y, {0, t1}, phistep::fixed(dt), [&](double t, const Pendulum& now) {
    const double error = energy(now) / E0 - 1;
    worst = std::max(worst, std::abs(error));
    if (out != nullptr) *out << name << ',' << dt << ',' << t << ',' << error << '\n';
    return worst < 1e3;
  });
  if (!report) return {std::nan(""), std::nan(""), report.statistics};
  return {angle(y), worst, report.statistics};
}

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  const auto rod = phistep::term([](const Vec& r) -> Vec { return -stiffness * (1 - rod_length / r.norm()) * r; });
  const phistep::Gravity gravity{Vec{0, -g}};
  const auto whole = rod + gravity;
  const auto split = rod + phistep::at(phistep::forward_euler, gravity);

  const double fine = options.is_short ? 1e-4 : 1e-5,
               exact = run("", whole, phistep::velocity_verlet, fine, nullptr).angle;
  std::printf("Swing angle at t = %g s: %.6f rad (Verlet, dt = %g s). Verlet's limit: dt = %g s.\n\n", t1, exact, fine,
              2 / std::sqrt(stiffness / bob));
  std::printf("%8s | %24s | %24s | %24s\n%8s | %12s %11s | %12s %11s | %12s %11s\n", "", "Verlet", "rod 1/2, gravity 0",
              "rod 1, gravity 0", "dt [s]", "angle error", "energy err.", "angle error", "energy err.", "angle error",
              "energy err.");
  auto energies = options.file("stiff_pendulum_energy.csv");
  energies << "scheme,dt_s,t_s,energy_error\n";
  auto errors = options.file("stiff_pendulum_error.csv");
  errors << "dt_s,verlet_rad,split_rad,damped_rad\n";
  bool as_expected = true;
  double previous = 0;
  for (const double dt : {5e-4, 1e-3, 2.5e-3, 5e-3, 1e-2, 2e-2}) {
    const Swing verlet = run("verlet", whole, phistep::velocity_verlet, dt, &energies);
    const Swing half = run("split", split, phistep::trapezoidal, dt, &energies);
    const Swing one = run("damped", split, phistep::backward_euler, dt, &energies);
    const double e[] = {std::abs(verlet.angle - exact), std::abs(half.angle - exact), std::abs(one.angle - exact)};
    std::printf("%8g | %12.1e %11.1e | %12.1e %11.1e | %12.1e %11.1e\n", dt, e[0], verlet.energy_error, e[1],
                half.energy_error, e[2], one.energy_error);
    errors << dt << ',' << e[0] << ',' << e[1] << ',' << e[2] << '\n';
    as_expected = as_expected && std::isnan(e[0]) == (dt > 2e-3) && half.statistics.kick_calls == 1 &&
                  (dt <= 2.5e-3 || std::abs(e[1] / previous - 4) < 0.2);
    previous = e[1];
  }
  std::printf("\nnan: blown up.%s\n",
              as_expected ? "" : " These are not the limits, orders and counts that theory asks for.");
  return as_expected ? 0 : 1;
}
