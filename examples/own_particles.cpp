// Your own particles, stepped in place: a std::vector of structs stays what it is, the library writes into it.
//
// `by_hand` is a loop as many programs have it; `by_phistep` is the same run with the loop replaced. The force is shared
// and the lines marked // + are all that is new. A ring of beads of different masses, joined by springs, spins freely:
// with the same Δt, the loop by hand gains energy, and another scheme of the library is one word away.
//
// A force that reads and writes the program's own arrays, rather than its argument: existing_code.cpp.
//
// Run: own_particles [--short] [--out DIR]
#include <phistep/phistep.hpp>  // +

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "command_line.hpp"

struct Bead {
  Eigen::Vector3d x, v;  // [m], [m/s]
  double m;              // [kg]
};
using Positions = Eigen::Matrix3Xd;
using Columns = Eigen::Map<Positions, 0, Eigen::OuterStride<>>;  // + one column a bead, the rest of it stepped over
using Masses = Eigen::Map<Eigen::VectorXd, 0, Eigen::InnerStride<>>;  // +
constexpr double stiffness = 100, rest_length = 0.5;                  // [N/m], [m]

/// Springs between neighbours along the ring, from the positions alone.
Positions ring_forces(const Positions& x) {
  Positions f = Positions::Zero(3, x.cols());
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const Eigen::Index j = (i + 1) % x.cols();
    const Eigen::Vector3d d = x.col(j) - x.col(i), pull = stiffness * (1 - rest_length / d.norm()) * d;
    f.col(i) += pull;
    f.col(j) -= pull;
  }
  return f;
}

void by_hand(std::vector<Bead>& beads, double t1, double dt) {
  for (double t = 0; t < t1 - dt / 2; t += dt) {
    Positions x(3, beads.size());
    for (std::size_t i = 0; i < beads.size(); ++i) x.col(static_cast<Eigen::Index>(i)) = beads[i].x;
    const Positions f = ring_forces(x);
    for (std::size_t i = 0; i < beads.size(); ++i) {
      beads[i].x += dt * beads[i].v;
      beads[i].v += dt / beads[i].m * f.col(static_cast<Eigen::Index>(i));
    }
  }
}

void by_phistep(std::vector<Bead>& beads, double t1, double dt, auto scheme) {
  const auto n = static_cast<Eigen::Index>(beads.size());
  const Eigen::OuterStride<> stride(sizeof(Bead) / sizeof(double));                                           // +
  phistep::Motion state{Columns(beads[0].x.data(), 3, n, stride), Columns(beads[0].v.data(), 3, n, stride)};  // +
  const Masses m(&beads[0].m, n, Eigen::InnerStride<>(stride.outer()));                                       // +
  phistep::PhiStepper stepper{state, ring_forces, scheme, phistep::mass(m)};                                  // +
  const auto report = phistep::integrate(stepper, state, {0, t1}, phistep::fixed(dt));                        // +
  if (!report) CommandLine::stop(report.message());                                                           // +
}

double energy(const std::vector<Bead>& beads) {
  double e = 0;
  for (std::size_t i = 0; i < beads.size(); ++i) {
    const double stretch = (beads[(i + 1) % beads.size()].x - beads[i].x).norm() - rest_length;
    e += 0.5 * beads[i].m * beads[i].v.squaredNorm() + 0.5 * stiffness * stretch * stretch;
  }
  return e;
}

int main(int argc, char** argv) {
  const CommandLine options(argc, argv);
  std::vector<Bead> start(12);
  for (std::size_t i = 0; i < start.size(); ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / 12;
    start[i] = {
        {std::cos(angle), std::sin(angle), 0}, {-2 * std::sin(angle), 2 * std::cos(angle), 0}, i % 2 ? 0.5 : 1.5};
  }
  const double t1 = options.is_short ? 1 : 5, dt = 0.002;
  std::printf("A ring of 12 beads after %g s in steps of %g s: energy gained, and where bead 0 is\n", t1, dt);
  const auto show = [&](const char* name, auto run) {
    auto beads = start;
    run(beads);
    const auto& x = beads[0].x;
    std::printf("  %-28s %+12.4f %%    (%9.5f, %9.5f) m\n", name, 100 * (energy(beads) / energy(start) - 1), x[0],
                x[1]);
    return beads[0].x;
  };
  const auto a = show("by hand (forward Euler)", [&](auto& beads) { by_hand(beads, t1, dt); });
  const auto b =
      show("phistep::forward_euler", [&](auto& beads) { by_phistep(beads, t1, dt, phistep::forward_euler); });
  show("phistep::backward_euler", [&](auto& beads) { by_phistep(beads, t1, dt, phistep::backward_euler); });
  show("phistep::midpoint", [&](auto& beads) { by_phistep(beads, t1, dt, phistep::midpoint); });
  show("phistep::velocity_verlet", [&](auto& beads) { by_phistep(beads, t1, dt, phistep::velocity_verlet); });
  std::printf("By hand and forward_euler differ by %.1e m: the same method, the same memory.\n", (a - b).norm());
  return (a - b).norm() < 1e-9 ? 0 : 1;
}
