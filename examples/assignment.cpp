// The assignment:   ρ C θ' = −B cos(2t) x + ρ a I,   θ(0) = θ₀,   at one point x of a body that is strained and lit.
//
// The right-hand side doesn't know θ, so it can be integrated in closed form,
//
//     θ(t) = θ₀ + [−½ B x sin(2t) + ρ a I t] / (ρ C),
//
// and each scheme is a quadrature rule: φ = 0 takes the rate at the start of the step, φ = 1 at its end, φ = ½ the mean,
//
//     θ(nΔt) = θ₀ + Δt/(ρC) Σ [φ Ψ((k+1)Δt) + (1−φ) Ψ(kΔt)],   k = 0 … n−1.
//
// The table shows θ(Δt), θ(2Δt), θ(3Δt) of the stepper, of this sum written out by hand, and of the closed form.
//
// Run: assignment [--short] [--out DIR]        Picture: python3 plot/plot_assignment.py [DIR]
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>

#include "command_line.hpp"

using Vec = Eigen::Vector<double, 1>;  // one temperature: a state of one component

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  const double rho = 1000, C = 2;             // density [kg/m³], heat capacity [J/(kg K)]
  const double B = 5000, x = 0.8;             // strain heating [W/m⁴] at the place x [m]
  const double a = 0.3, I = 4, theta0 = 300;  // absorptivity [1/m], light [W m/kg]: ρ a I is in W/m³; [K]
  const double dt = 0.3;                      // [s]

  const auto Psi = [=](double t) { return -B * std::cos(2 * t) * x + rho * a * I; };
  const auto heating = [=](const Vec& /*theta*/, double t) -> Vec { return Vec{Psi(t)}; };
  const auto exact = [=](double t) { return theta0 + (-0.5 * B * x * std::sin(2 * t) + rho * a * I * t) / (rho * C); };

  std::printf("theta [K] with dt = %g s\n%26s %14s %14s %14s\n", dt, "", "t = dt", "t = 2 dt", "t = 3 dt");
  std::printf("%-26s %14.9f %14.9f %14.9f\n", "closed form", exact(dt), exact(2 * dt), exact(3 * dt));
  auto file = options.file("assignment.csv");
  file << "scheme,t_s,theta_K\n";
  for (int k = 0; k <= 90; ++k) file << "exact," << 0.01 * k << ',' << exact(0.01 * k) << '\n';

  double worst = 0;
  const auto run = [&](const char* name, auto scheme, double phi) {
    Vec theta{theta0};
    phistep::PhiStepper stepper{theta, heating, scheme, phistep::capacity(rho * C)};
    double by_hand = theta0, stepped[3], summed[3];
    file << name << ",0," << theta0 << '\n';
    for (int n = 0; n < 3; ++n) {
      if (const auto step = stepper.step(theta, n * dt, dt); !step) CommandLine::stop(step.message());
      by_hand += dt / (rho * C) * (phi * Psi((n + 1) * dt) + (1 - phi) * Psi(n * dt));
      stepped[n] = theta[0];
      summed[n] = by_hand;
      worst = std::max(worst, std::abs(stepped[n] - summed[n]));
      file << name << ',' << (n + 1) * dt << ',' << theta[0] << '\n';
    }
    std::printf("%-26s %14.9f %14.9f %14.9f\n", name, stepped[0], stepped[1], stepped[2]);
    std::printf("%-26s %14.9f %14.9f %14.9f\n", "    by hand", summed[0], summed[1], summed[2]);
    std::printf("%-26s %+14.9f %+14.9f %+14.9f\n", "    error", stepped[0] - exact(dt), stepped[1] - exact(2 * dt),
                stepped[2] - exact(3 * dt));
  };
  run("forward Euler (phi = 0)", phistep::forward_euler, 0);
  run("trapezoidal (phi = 1/2)", phistep::trapezoidal, 0.5);
  run("backward Euler (phi = 1)", phistep::backward_euler, 1);
  std::printf("Stepper and sum by hand differ by %.1e K at most.\n", worst);
  return worst < 1e-12 ? 0 : 1;
}
