// The solar system from real data: ten bodies under Newton's gravity, started from the JPL ephemeris DE421 at J2000.0 and
// compared with it at every later epoch of the file, for six schemes and several Δt.
//
// The first table shows error, energy, angular momentum and CPU time by scheme and Δt after ten years, the second the
// error of every body up to 49 years. Newton's point masses leave out relativity, the Moon and the asteroids: even solved
// exactly they are off after ten years by 1.2e-5 au for Mercury, 3.7e-6 for Earth and Moon, 4.8e-7 for Jupiter, 1e-9 for
// Neptune. The program fails where velocity Verlet puts Jupiter more than 1e-6 au or Neptune more than 1e-7 au off.
//
// Run: solar_system [--short] [--out DIR] [--data planets_de421.txt]      Picture: python3 plot/plot_solar_system.py [DIR]
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdio>
#include <ctime>

#include "command_line.hpp"
#include "planets.hpp"

using Bodies = Ephemeris::Bodies;
constexpr int N = Ephemeris::bodies;

/// a_i = Σ_j GM_j (r_j − r_i) / |r_j − r_i|³ [au/day²]: an acceleration, so the stepper's masses stay 1. The implicit schemes
/// get their Jacobian by differences, and keep it for many steps.
struct Gravitation {
  Eigen::Vector<double, N> GM;

  Bodies operator()(const Bodies& r) const {
    Bodies a = Bodies::Zero();
    for (int i = 0; i < N; ++i)
      for (int j = i + 1; j < N; ++j) {
        const Eigen::Vector3d d = r.col(j) - r.col(i), pull = d / (d.squaredNorm() * d.norm());
        a.col(i) += GM[j] * pull;
        a.col(j) -= GM[i] * pull;
      }
    return a;
  }
};

int main(int argc, char** argv) {
  CommandLine options(argc, argv, {{"--data", default_data}});
  const Ephemeris de421 = read_ephemeris(options.own["--data"]);
  const Eigen::Index all = static_cast<Eigen::Index>(de421.epochs.size()) - 1;  // epochs after the first
  const Eigen::Index judged = options.is_short ? 1 : 4;                         // the one after 1 or 10 years

  auto file = options.file("solar_system_errors.csv");
  file << "scheme,dt_day,t_year,body,error_au,energy_error,angular_momentum_error,cpu_s\n";
  // Steps of a year / n, which divide the time from epoch to epoch. Returns the errors [au]: a row a body, a column an epoch.
  const auto run = [&](const char* name, auto scheme, int n, Eigen::Index epochs, auto&&... observers) {
    phistep::Motion state{de421.epoch(0).r, de421.epoch(0).v};
    phistep::PhiStepper stepper{state, Gravitation{de421.GM}, scheme};
    const double E0 = energy(de421, state), dt = 365.25 / n;
    const Eigen::Vector3d L0 = angular_momentum(de421, state);
    Eigen::MatrixXd error = Eigen::MatrixXd::Constant(N, epochs, NAN);
    double dE = 0, dL = 0, cpu = 0;
    for (Eigen::Index e = 0; e < epochs; ++e) {
      const Ephemeris::Epoch &from = de421.epoch(e), &to = de421.epoch(e + 1);
      const std::clock_t start = std::clock();
      const auto report = phistep::integrate(stepper, state, {from.t, to.t}, phistep::fixed(dt), observers...);
      cpu += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      if (!report) {
        std::printf("%-17s %8.4f  %s on day %.0f, with Mercury %.3f au from the Sun\n", name, dt,
                    phistep::describe(report.outcome), report.t, (state.r.col(1) - state.r.col(0)).norm());
        return error;
      }
      dE = energy(de421, state) / E0 - 1;
      dL = (angular_momentum(de421, state) - L0).norm() / L0.norm();
      error.col(e) = (state.r - to.r).colwise().norm();
      for (int body = 0; body < N; ++body)
        file << name << ',' << dt << ',' << to.t / 365.25 << ',' << de421.name(body) << ',' << error(body, e) << ','
             << dE << ',' << dL << ',' << cpu << '\n';
    }
    const auto last = error.col(epochs - 1);
    if (epochs == judged)
      std::printf("%-17s %8.4f %10.1e %10.1e %10.1e %10.1e %11.1e %10.1e %8.3f\n", name, dt, last[1], last[3], last[5],
                  last[8], dE, dL, cpu);
    return error;
  };

  std::printf("Error after %g years against DE421 [au], relative error of energy and angular momentum\n",
              de421.years(judged));
  std::printf("%-17s %8s %10s %10s %10s %10s %11s %10s %8s\n", "scheme", "dt [day]", "Mercury", "EarthMoon", "Jupiter",
              "Neptune", "energy", "ang. mom.", "CPU [s]");
  const auto each_dt = [&](const char* name, auto scheme, int finest) {
    for (int n = 96; n <= (options.is_short ? 384 : finest); n *= 4) run(name, scheme, n, judged);
  };
  each_dt("velocity_verlet", phistep::velocity_verlet, 24576);
  each_dt("midpoint", phistep::midpoint, 24576);
  each_dt("trapezoidal", phistep::trapezoidal, 24576);
  each_dt("symplectic_euler", phistep::symplectic_euler, 24576);
  each_dt("backward_euler", phistep::backward_euler, 98304);
  each_dt("forward_euler", phistep::forward_euler, 24576);

  auto orbits = options.file("solar_system_orbits.csv");
  auto draw = phistep::every(4.0, [&](double t, const auto& y) { write_positions(orbits, de421, t, y.r); });
  const int n = options.is_short ? 1536 : 6144;
  const Eigen::MatrixXd error = run("velocity_verlet", phistep::velocity_verlet, n, options.is_short ? 2 : all, draw);
  std::printf("\nError of velocity_verlet with dt = %.4f days against DE421 [au]\n", 365.25 / n);
  print_errors(de421, error);
  const double jupiter = error(5, judged - 1), neptune = error(8, judged - 1);
  const bool good = jupiter < (options.is_short ? 2e-7 : 1e-6) && neptune < (options.is_short ? 1e-8 : 1e-7);
  std::printf("%s\n", good ? "Jupiter and Neptune are where they should be." : "Jupiter or Neptune is too far off.");
  return good ? 0 : 1;
}
