// Heat in a plate:   ρc θ' = ∇·(k ∇θ),   θ = 0 at the edges, copper with a strip of steel in it, and a hot square at t = 0.
//
// Finite volumes give M θ' = A θ with A sparse; any φ ≥ ½ takes any Δt. But φ = ½ multiplies what it can't resolve by
// almost −1, so the jump around the hot square rings: temperatures below those of the edges appear, which no conduction can
// make. Two cures: two backward Euler half steps at the start (Rannacher), which restore order 2 as well, or a
// Δt ≤ ρc Δx² / (4 k (1−φ)) (the discrete maximum principle in 2-D), which costs many steps.
//
// Run: heat [--short] [--out DIR]        Picture: python3 plot/plot_heat.py [DIR]
// heat.vtk, the plate after three steps, opens in ParaView and PyVista.
#include <phistep/io.hpp>
#include <phistep/sparse.hpp>

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "command_line.hpp"
#include "plate.hpp"

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  const Plate plate(options.is_short ? 48 : 80);
  const Conduction conduction = plate.conduction();
  const double t1 = 4, dt = 0.25;                                                                     // [s]
  const double bound = 1 / conduction.A.diagonal().cwiseAbs().cwiseQuotient(plate.rho_c).maxCoeff();  // ρc Δx²/(4k) [s]

  struct Result {
    Vec end, after_3_steps;
    double lowest;
    phistep::Statistics work;
  };
  const auto run = [&](auto scheme, double step, bool rannacher) {
    Result result{plate.start, {}, 0, {}};
    Vec& theta = result.end;
    const auto look = [&](double t, const Vec& now) {
      result.lowest = std::min(result.lowest, now.minCoeff());
      if (std::abs(t - 3 * step) < step / 4) result.after_3_steps = now;
    };
    const auto advance = [&](auto phi, double from, double to, double by) {
      phistep::PhiStepper stepper{theta, conduction, phi, phistep::capacity(plate.rho_c),
                                  phistep::newton<Eigen::SimplicialLDLT<Matrix>>()};
      const auto report = phistep::integrate(stepper, theta, {from, to}, phistep::fixed(by), look);
      if (!report) CommandLine::stop(report.message());
      result.work = report.statistics;
    };
    if (rannacher) advance(phistep::backward_euler, 0, step, step / 2);
    advance(scheme, rannacher ? step : 0, t1, step);
    return result;
  };

  const Vec exact = run(phistep::trapezoidal, dt / 16, true).end;  // of the plate's cells, to 1e-4 K or so
  std::printf("%d x %d cells, t = %g s. Edges at 0 K: nothing may ever be colder.\n", plate.n, plate.n, t1);
  std::printf("%-34s %10s %7s %8s %11s %14s %7s\n", "", "dt [s]", "steps", "factors", "coldest [K]", "error [K]",
              "order");
  double last_error = 0, order = 0;
  const auto show = [&](const char* name, auto scheme, double step, bool rannacher, bool halved = false) {
    const Result result = run(scheme, step, rannacher);
    const double error = (result.end - exact).lpNorm<Eigen::Infinity>();
    order = std::log2(last_error / error);
    last_error = error;
    std::printf("%-34s %10.6f %7d %8d %11.4f %14.6f", name, step, static_cast<int>(result.work.steps),
                static_cast<int>(result.work.factorizations), result.lowest, error);
    std::printf(halved ? " %7.2f\n" : "\n", order);
    return result;
  };
  const Result ringing = show("trapezoidal, phi = 1/2", phistep::trapezoidal, dt, false);
  show("", phistep::trapezoidal, dt / 2, false, true);
  show("", phistep::trapezoidal, dt / 4, false, true);
  const Result cured = show("two half steps of phi = 1 first", phistep::trapezoidal, dt, true);
  show("", phistep::trapezoidal, dt / 2, true, true);
  show("", phistep::trapezoidal, dt / 4, true, true);
  const bool second_order = order > 1.8;
  show("phi = 0.7", phistep::phi(0.7), dt, false);
  show("backward Euler, phi = 1", phistep::backward_euler, dt, false);
  show("", phistep::backward_euler, dt / 2, false, true);
  const Result slow = show("trapezoidal, dt at the bound", phistep::trapezoidal, 2 * bound, false);
  show("forward Euler, dt at its bound", phistep::forward_euler, bound, false);

  auto file = options.file("heat_field.csv");
  file << "x_m,y_m,theta_phi_half_K,theta_rannacher_K,k_W_per_mK\n";
  for (int i = 0; i < plate.n * plate.n; ++i)
    file << (i % plate.n + 0.5) * plate.dx << ',' << (i / plate.n + 0.5) * plate.dx << ',' << ringing.after_3_steps[i]
         << ',' << cured.after_3_steps[i] << ',' << plate.k[i] << '\n';
  const phistep::VtkGrid grid{
      .size = {plate.n, plate.n}, .spacing = {plate.dx, plate.dx}, .on_cells = true, .names = {"theta_rannacher"}};
  phistep::write_vtk(options.out / "heat.vtk", cured.after_3_steps, grid,
                     phistep::column("theta_phi_half", ringing.after_3_steps),
                     phistep::column("conductivity", plate.k));
  const bool as_expected = ringing.lowest < -1 && cured.lowest > -1e-3 && slow.lowest > -1e-9 && second_order;
  if (!as_expected) std::printf("This is not what theory asks for: ringing, both cures, order 2.\n");
  return as_expected ? 0 : 1;
}
