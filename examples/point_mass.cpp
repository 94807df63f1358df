// A point mass under φ = 0, ½ and 1, beside the exact solution.
//
//   1. A ball thrown through oil, m v' = m g − c v: halving Δt halves the error of φ = 0 and φ = 1 (order 1) and quarters
//      that of φ = ½ (order 2).
//   2. A mass on a spring, m v' = −k r: each step multiplies the energy by exactly (1 + (1−φ)²a²) / (1 + φ²a²), a = ωΔt.
//      So φ = 0 gains 1 + a² a step however small Δt is, φ = 1 loses as much, φ = ½ keeps it.
//
// Run: point_mass [--short] [--out DIR]        Picture: python3 plot/plot_point_mass.py [DIR]
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "command_line.hpp"

using Vec = Eigen::Vector2d;

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  const double all_phi[] = {0.0, 0.5, 1.0};
  bool as_expected = true;

  // 1. The throw. Gravity and drag are terms of the library; any two forces add like this.
  const double m = 0.5, c = 0.4, t1 = 2.0;  // [kg], [N s/m], [s]
  const Vec g{0.0, -9.81}, v0{12.0, 16.0};  // [m/s²], [m/s]
  const Vec v_end = g * (m / c);            // the speed at which drag carries the weight
  const Vec exact = v_end * t1 + (v0 - v_end) * (m / c) * (1 - std::exp(-t1 * c / m));

  std::printf("The throw: distance from the exact landing point at t = %g s [m], and the order seen\n", t1);
  std::printf("%10s %22s %22s %22s\n", "dt [s]", "phi = 0", "phi = 1/2", "phi = 1");
  auto errors = options.file("point_mass_error.csv");
  errors << "dt_s,phi,error_m\n";
  double previous[3] = {}, order[3] = {};
  for (const double dt : {0.2, 0.1, 0.05, 0.025, 0.0125}) {
    std::printf("%10g", dt);
    for (int k = 0; k < 3; ++k) {
      phistep::Motion ball{Vec{0, 0}, v0};
      phistep::PhiStepper stepper{ball, phistep::Gravity{g} + phistep::LinearDrag{c}, phistep::phi(all_phi[k]),
                                  phistep::mass(m)};
      if (const auto report = phistep::integrate(stepper, ball, {0, t1}, phistep::fixed(dt)); !report)
        CommandLine::stop(report.message());
      const double error = (ball.r - exact).norm();
      order[k] = std::log2(previous[k] / error);
      previous[k] = error;
      if (dt == 0.2) std::printf("  %12.6f        ", error);
      else std::printf("  %12.6f  (%.2f)", error, order[k]);
      errors << dt << ',' << all_phi[k] << ',' << error << '\n';
    }
    std::printf("\n");
  }
  for (int k = 0; k < 3; ++k) as_expected = as_expected && std::abs(order[k] - (k == 1 ? 2 : 1)) < 0.05;

  // 2. The spring. The mass runs around a circle of radius 1 m, which energy gained or lost turns into a spiral.
  const double M = 2.0, k_spring = 8.0, omega = std::sqrt(k_spring / M), dt = 0.05, a = omega * dt;
  const double period = 2 * std::numbers::pi / omega;
  const auto spring = [=](const Vec& r) -> Vec { return -k_spring * r; };
  const auto energy = [=](const auto& y) { return 0.5 * M * y.v.squaredNorm() + 0.5 * k_spring * y.r.squaredNorm(); };

  std::printf("\nThe spring: a = omega dt = %g, energy gained or lost\n", a);
  std::printf("%6s %16s %24s %22s\n", "phi", "E1/E0", "by the formula", "E/E0 after 5 periods");
  auto orbit = options.file("point_mass_orbit.csv");
  orbit << "phi,t_s,x_m,y_m,energy_J\n";
  for (const double phi : all_phi) {
    phistep::Motion bob{Vec{1, 0}, Vec{0, omega}};
    const double E0 = energy(bob);
    phistep::PhiStepper stepper{bob, spring, phistep::phi(phi), phistep::mass(M)};
    double first = 0;
    const auto report =
        phistep::integrate(stepper, bob, {0, 5 * period}, phistep::fixed(dt), [&](double t, const auto& y) {
          orbit << phi << ',' << t << ',' << y.r.x() << ',' << y.r.y() << ',' << energy(y) << '\n';
          if (t == dt) first = energy(y) / E0;
        });
    if (!report) CommandLine::stop(report.message());
    const double formula = (1 + std::pow((1 - phi) * a, 2)) / (1 + std::pow(phi * a, 2));
    std::printf("%6g %16.12f %24.12f %22.12f\n", phi, first, formula, energy(bob) / E0);
    as_expected = as_expected && std::abs(first - formula) < 1e-14;
  }
  if (!as_expected) std::printf("\nThese are not the orders and energies that theory asks for.\n");
  return as_expected ? 0 : 1;
}
