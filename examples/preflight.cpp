// Ask before the first step: a footbridge of bonded particles, hung on a tie rod ten thousand times as stiff as its bonds.
//
// Its swing takes half a second, so a step of 1 ms with Verlet looks safe: five hundred steps a swing. `preflight` says that
// it isn't, which term is to blame and at which particle, up to which Δt Verlet would be stable, and what to write instead.
// Then the bridge is let go under its own weight, its rod struck, and what happens is what was said: Verlet at 1 ms blows
// up; far below the limit it is right, at many steps; φ = ½ at 1 ms is stable, but the rod's force jumps from step to step
// for ever; TR-BDF2 at 1 ms shows the same swing with the rod quiet.
//
// Run: preflight [--short]
#include <phistep/phistep.hpp>
#include <phistep/preflight.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <vector>

#include "command_line.hpp"

using Positions = Eigen::Matrix2Xd;
using Bridge = phistep::Motion<Positions>;

constexpr int wide = 24, height = 4, middle = wide / 2;                      // particles; number along and up, mid-span
constexpr double spacing = 0.25, bead = 1, bond = 5e4, rod = 5e8, g = 9.81;  // [m] [kg] [N/m] [N/m] [m/s²]

/// The ends of the bridge are held by springs to where they started.
struct Supports : phistep::ForceTerm {
  Positions home;  // [m]
  static constexpr bool uses_velocity = false, uses_time = false, is_affine = true;
  static constexpr phistep::Structure structure = phistep::Structure::diagonal;
  static bool held(Eigen::Index i) { return i % wide == 0 || i % wide == wide - 1; }
  void add(double, const auto& y, auto& out) const {
    for (Eigen::Index i = 0; i < home.cols(); ++i)
      if (held(i)) out.force.col(i) += bond * (home.col(i) - y.r.col(i));
  }
  void add_jacobian(double, const auto&, auto& sink) const {
    for (Eigen::Index a = 0; a < home.size(); ++a)
      if (held(a / 2)) sink.position(a, a, -bond);
  }
};

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  Positions r(2, wide * height);
  for (int i = 0; i < r.cols(); ++i) r.col(i) << spacing * (i % wide), spacing * (i / wide);
  std::vector<phistep::Spring> bonds, rods;
  for (int i = 0; i < r.cols(); ++i)
    for (int j = i + 1; j < r.cols(); ++j)
      if (const double apart = (r.col(i) - r.col(j)).norm(); apart < 1.5 * spacing)
        bonds.push_back({i, j, bond, apart});
  for (int i = 0; i + 1 < wide; ++i) rods.push_back({i, i + 1, rod, spacing});
  const auto force = phistep::spring_network<2>(bonds) + phistep::spring_network<2>(rods) + Supports{{}, r} +
                     phistep::Gravity{Eigen::Vector2d{0, -g}};
  Bridge start{r, Positions::Zero(2, r.cols())};
  start.v(0, middle) = 0.05;                                               // a hammer's blow along the rod [m/s]
  const double swing = 0.5, wanted = 1e-3, t1 = options.is_short ? 1 : 4;  // [s]

  phistep::PhiStepper verlet{start, force, phistep::velocity_verlet, phistep::mass(bead)};
  const auto report = phistep::preflight(verlet, start, wanted, {.period = swing});
  std::cout << "Verlet at 1 ms?\n" << report;
  phistep::PhiStepper half{start, force, phistep::trapezoidal, phistep::mass(bead)};
  std::cout << "\nThe trapezoidal rule?\n" << phistep::preflight(half, start, wanted, {.period = swing});

  struct Run {
    double sag = 0,
           zigzag = 0;  // [m] the deepest; [N] of the rod's force from step to step, root mean square, at the end
    bool blew_up = true;
  };
  std::printf("\n%-26s %8s %12s %20s\n", "", "steps", "sag [m]", "zigzag of rod [N]");
  const auto run = [&](const char* name, auto scheme, double dt) {
    phistep::PhiStepper stepper{start, force, scheme, phistep::mass(bead)};
    Bridge y = start;
    Run result;
    double pull[3] = {}, sum = 0, count = 0;
    const auto done = phistep::integrate(stepper, y, {0, t1}, phistep::fixed(dt), [&](double t, const Bridge& now) {
      const double sag = -now.r(1, middle);
      pull[2] = pull[1], pull[1] = pull[0];
      pull[0] = rod * ((now.r.col(middle + 1) - now.r.col(middle)).norm() - spacing);
      if (t > 0.8 * t1) sum += std::pow((pull[0] - 2 * pull[1] + pull[2]) / 4, 2), ++count;
      result.sag = std::max(result.sag, sag);
      return std::abs(sag) < 10;
    });
    result.blew_up = !done;
    result.zigzag = std::sqrt(sum / std::max(1.0, count));
    std::printf("%-26s %8ld", name, static_cast<long>(done.statistics.steps));
    std::printf(done ? " %12.5f %20.2f\n" : "    blown up\n", result.sag, result.zigzag);
    return result;
  };
  const Run asked = run("Verlet, 1 ms", phistep::velocity_verlet, wanted);
  const Run resolved = run("Verlet, 1/5 of stable", phistep::velocity_verlet, report.stable_dt / 5);
  const Run rings = run("trapezoidal, 1 ms", phistep::trapezoidal, wanted);
  const Run advised = run("TR-BDF2, 1 ms", phistep::tr_bdf2, report.recommended.dt);
  const bool as_said = asked.blew_up && report.recommended.scheme == "tr_bdf2" && !advised.blew_up &&
                       std::abs(advised.sag / resolved.sag - 1) < 0.01 && rings.zigzag > 20 * advised.zigzag;
  std::puts(as_said ? "\nAs preflight said." : "\nThis is not what preflight said.");
  return as_said ? 0 : 1;
}
