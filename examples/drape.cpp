// A square cloth of 6400 particles and 38,000 springs falls on a sphere and drapes it: implicit, in steps of 2 ms.
//
// The sphere is a force term written here: particles nearer than a thickness are pushed out by springs, and rubbed by a
// viscous friction. Each particle's force depends on itself alone, so that beside the springs' network it costs nothing to
// solve: conjugate gradients on the springs, as in cloth.cpp. Where folds buckle and particles touch, a step may fail; it is
// then taken in halves. At rest the sphere carries the cloth's weight.
//
// Run: drape [--short] [--out DIR] [--side PARTICLES]
// Frames: drape.vtk.series opens in ParaView and PyVista, drape.xyz in OVITO and ASE
// Picture: python3 plot/plot_drape.py [DIR]
#include <phistep/io.hpp>
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <utility>

#include "command_line.hpp"
#include "mesh.hpp"
#include "progress.hpp"

using Eigen::Vector3d;

/// A fixed sphere that pushes out what comes nearer than its radius, and rubs.
struct Sphere : phistep::ForceTerm {
  Vector3d center;  // [m]
  double radius;    // [m] with the cloth's thickness
  double k, rub;    // [N/m], [N s/m] of one particle

  static constexpr bool uses_velocity = true, uses_time = false, is_symmetric = true;
  static constexpr phistep::Structure structure = phistep::Structure::local;
  static constexpr int block = 3;

  /// f(i, n, depth, distance) for each particle i inside, n the normal there.
  void for_each_inside(const auto& r, auto&& f) const {
    for (Eigen::Index i = 0; i < r.cols(); ++i) {
      const Vector3d from = r.col(i) - center;
      const double distance = from.norm();
      if (distance < radius) f(i, Vector3d(from / distance), radius - distance, distance);
    }
  }
  void add(double /*t*/, const auto& y, auto& out) const {
    for_each_inside(y.r, [&](Eigen::Index i, const Vector3d& n, double depth, double) {
      const Vector3d v = y.v.col(i);
      out.force.col(i) += k * depth * n - rub * (v - n.dot(v) * n);
    });
  }
  /// ∂f/∂r = −k n nᵀ + k depth/distance (I − n nᵀ), without its second part, which could make the matrix indefinite.
  void add_jacobian(double /*t*/, const auto& y, auto& sink) const {
    for_each_inside(y.r, [&](Eigen::Index i, const Vector3d& n, double, double) {
      for (Eigen::Index a = 0; a < 3; ++a)
        for (Eigen::Index b = 0; b < 3; ++b) {
          sink.position(3 * i + a, 3 * i + b, -k * n[a] * n[b]);
          sink.velocity(3 * i + a, 3 * i + b, -rub * ((a == b ? 1 : 0) - n[a] * n[b]));
        }
    });
  }
};

int main(int argc, char** argv) {
  CommandLine options(argc, argv, {{"--side", ""}});
  const long side = options.whole("--side", options.is_short ? 20 : 80, 3);
  const Mesh mesh = grid(side);
  const double t1 = options.is_short ? 0.2 : 1, dt = 0.002;                      // [s]
  const double stretch = 200, bend = 5, density = 0.2, g = 9.81, drag_rate = 1;  // [N/m] [N/m] [kg/m²] [m/s²] [1/s]
  const Eigen::VectorXd m = masses_of(mesh, density);
  const Sphere sphere{{}, {0.5, 0.5, -0.34}, 0.305, 50 * m.mean() * g / 1e-3, 40 * m.mean()};
  const auto force = phistep::spring_network<3>(springs_of(mesh, stretch, bend)) +
                     phistep::Gravity{Vector3d{0, 0, -g}} + phistep::LinearDrag{drag_rate * m.mean()} + sphere;

  phistep::Motion cloth{mesh.vertices, Eigen::Matrix3Xd::Zero(3, mesh.vertices.cols())};
  phistep::PhiStepper stepper{cloth, force, phistep::backward_euler, phistep::mass(m),
                              phistep::newton({.rtol = 1e-2, .atol = 1e-6, .max_iterations = 40})};
  std::printf("%ld particles; solver: %s\n", long(m.size()), stepper.solver_name());
  phistep::Halving halving{std::move(stepper), 10};

  auto curves = options.file("drape.csv"), frames = options.file("drape.xyz"),
       triangles = options.file("drape_triangles.csv");
  curves << "t_s,kinetic_J,height_J,carried_N,weight_N\n";
  const auto carried = [&](const auto& y) {
    double up = 0;
    sphere.for_each_inside(
        y.r, [&](Eigen::Index, const Vector3d& n, double depth, double) { up += sphere.k * depth * n[2]; });
    return up;
  };
  const auto look = [&](double t, const auto& y) {
    curves << t << ',' << 0.5 * y.v.colwise().squaredNorm().dot(m) << ',' << g * y.r.row(2).dot(m) << ',' << carried(y)
           << ',' << m.sum() * g << '\n';
  };
  const std::clock_t began = std::clock();
  const auto report = phistep::integrate(
      halving, cloth, {0, t1}, phistep::fixed(dt), progress(t1), look,
      phistep::every(0.02, phistep::vtk_series(options.out / "drape", phistep::VtkMesh{.triangles = mesh.triangles})),
      phistep::every(t1 / 6, [&](double t, const auto& y) {
        phistep::write_extended_xyz(frames, t, y.r, y.v, {.species = {"C"}});
      }));
  const double seconds = double(std::clock() - began) / CLOCKS_PER_SEC;
  std::cout << report;
  std::printf("%.1f ms a step. The sphere carries %.4f N, the cloth weighs %.4f N.\n",
              1e3 * seconds / double(std::max<std::int64_t>(1, report.statistics.steps)), carried(cloth), m.sum() * g);
  triangles << "a,b,c\n";
  for (const auto& t : coarse_triangles(side)) triangles << t[0] << ',' << t[1] << ',' << t[2] << '\n';
  return report ? 0 : 1;
}
