// A cloth of 40,000 particles and 240,000 springs, 1 m wide, let go flat with one edge held: implicit, in steps some ninety
// times longer than an explicit scheme could take.
//
// Springs are a network, and the library knows how to solve with one: conjugate gradients that never assemble a matrix. It
// says so below. Two things beside: the edge hangs in stiff springs, a force term written here (no particle needs special
// treatment, the matrix stays symmetric, and stiffness costs an implicit scheme little). And where the cloth buckles a step
// may fail; it then leaves the state as it was, so `Halving`, a stepper around a stepper, takes the same step in two halves.
//
// Run: cloth [--short] [--out DIR] [--mesh FILE.off] [--side PARTICLES]
// Frames: cloth.xyz (extended XYZ) opens in OVITO and ASE        Picture: python3 plot/plot_cloth.py [DIR]
#include <phistep/io.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <string>
#include <utility>

#include "command_line.hpp"
#include "mesh.hpp"
#include "progress.hpp"

/// Particles held where they started, with the force −k (r − home).
struct Pins : phistep::ForceTerm {
  std::vector<Eigen::Index> held;
  Eigen::Matrix3Xd home;  // [m] of all
  double k = 1e4;         // [N/m]

  static constexpr bool uses_velocity = false, uses_time = false;
  static constexpr phistep::Structure structure = phistep::Structure::diagonal;  // of ∂force/∂r

  [[nodiscard]] Eigen::Vector3d pull(Eigen::Index i, const auto& r) const { return k * (home.col(i) - r.col(i)); }
  void add(double /*t*/, const auto& y, auto& out) const {
    for (const Eigen::Index i : held) out.force.col(i) += pull(i, y.r);
  }
  void add_jacobian(double /*t*/, const auto& /*y*/, auto& sink) const {
    for (const Eigen::Index i : held)
      for (Eigen::Index a = 3 * i; a < 3 * i + 3; ++a) sink.position(a, a, -k);
  }
};

int main(int argc, char** argv) {
  CommandLine options(argc, argv, {{"--mesh", ""}, {"--side", ""}});
  const std::string& file = options.own["--mesh"];
  const long side = options.whole("--side", options.is_short ? 24 : 200, 2);
  const Mesh mesh = file.empty() ? grid(side) : read_off(file);
  const double t1 = 0.3, dt = 0.005;                                              // [s]
  const double stretch = 300, bend = 30, density = 0.2, g = 9.81, drag_rate = 2;  // [N/m] [kg/m²] [m/s²] [1/s]

  const Eigen::Matrix3Xd& start = mesh.vertices;
  const Eigen::VectorXd m = masses_of(mesh, density);
  Pins pins{{}, {}, start};
  for (Eigen::Index i = 0; i < start.cols(); ++i)
    if (start(1, i) > start.row(1).maxCoeff() - 1e-9) pins.held.push_back(i);
  const auto springs = springs_of(mesh, stretch, bend);
  const auto force = phistep::spring_network<3>(springs) + phistep::Gravity{Eigen::Vector3d{0, 0, -g}} +
                     phistep::LinearDrag{drag_rate * m.mean()} + pins;

  phistep::Motion cloth{start, Eigen::Matrix3Xd::Zero(3, start.cols())};
  phistep::PhiStepper stepper{cloth, force, phistep::backward_euler, phistep::mass(m),
                              phistep::newton({.rtol = 1e-2, .atol = 1e-6, .max_iterations = 20})};
  const std::string solver = stepper.solver_name();
  phistep::Halving halving{std::move(stepper), 10};

  // Gershgorin: ω² ≤ 2 Σk/m at the particle where that is largest; Verlet is stable up to ωΔt = 2.
  Eigen::VectorXd stiffness = Eigen::VectorXd::Zero(m.size());
  for (const auto& s : springs) stiffness[s.i] += s.stiffness, stiffness[s.j] += s.stiffness;
  const double explicit_dt = 2 / std::sqrt(2 * stiffness.cwiseQuotient(m).maxCoeff());
  std::printf("%ld particles, %zu springs, %g s in steps of %g ms; an explicit scheme needs %.3f ms\nsolver: %s\n",
              static_cast<long>(start.cols()), springs.size(), t1, 1e3 * dt, 1e3 * explicit_dt, solver.c_str());
  auto frames = options.file("cloth.xyz");
  frames.precision(7);
  const std::clock_t began = std::clock();
  const auto report = phistep::integrate(
      halving, cloth, {0, t1}, phistep::fixed(dt), progress(t1),
      phistep::every(0.1, [&](double t, const auto& y) { phistep::write_extended_xyz(frames, t, y.r, y.v); }));
  const double ms = 1e3 * static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  std::cout << report;

  Eigen::Vector3d carried = Eigen::Vector3d::Zero();
  for (const Eigen::Index i : pins.held) carried += pins.pull(i, cloth.r);
  double longest = 0;
  for (const auto& s : springs)
    longest = std::max(longest, (cloth.r.col(s.i) - cloth.r.col(s.j)).norm() / s.length - 1);
  std::printf(
      "%.1f ms a step. The pinned edge carries %.3f N, the cloth weighs %.3f N; the longest spring is stretched by "
      "%.1f %%, the\n"
      "lowest point is at %.3f m.\n",
      ms / static_cast<double>(std::max<std::int64_t>(1, report.statistics.steps)), carried.norm(), m.sum() * g,
      100 * longest, cloth.r.row(2).minCoeff());
  auto triangles = options.file("cloth_triangles.csv");
  triangles << "a,b,c\n";
  for (const auto& t : file.empty() ? coarse_triangles(side) : mesh.triangles)
    triangles << t[0] << ',' << t[1] << ',' << t[2] << '\n';
  return report ? 0 : 1;
}
