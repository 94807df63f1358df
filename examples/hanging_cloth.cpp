// A hanging cloth: a square of 1 m made of 7,000 springs, let go flat, two corners held. Implicit and sparse, in steps
// some thirty times longer than an explicit scheme could take.
//
// Two things to see beside the stepper. The corners hang in stiff springs from two hands that move, a force term written
// here: no particle needs special treatment, the matrix stays symmetric, and stiffness costs an implicit scheme nothing.
// And where the cloth whips or buckles, a step can fail: Newton diverges, or Cholesky meets a compressed spring's indefinite
// tangent and refuses it. A failed step leaves the state as it was, so `Halving`, a stepper around a stepper, takes the same
// step in two halves.
//
// Run: hanging_cloth [--short] [--out DIR] [--mesh FILE.off] [--side PARTICLES]
// Frames: cloth.xyz (extended XYZ) opens in OVITO and ASE        Picture: python3 plot/plot_hanging_cloth.py [DIR]
#include <phistep/io.hpp>
#include <phistep/sparse.hpp>

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cstdio>
#include <iostream>

#include "command_line.hpp"
#include "mesh.hpp"

using Cholesky = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

/// Two hands that hold a particle each with the force −k (r − place), and come closer by 0.2 m during the first second.
struct Hands : phistep::ForceTerm {
  Eigen::Index held[2];
  Eigen::Vector3d home[2], inward;  // [m] at t = 0; the way from hand 0 to hand 1
  double k = 1e5;                   // [N/m]

  static constexpr bool uses_velocity = false, uses_time = true;
  static constexpr phistep::Structure structure = phistep::Structure::diagonal;  // of ∂force/∂r

  Hands(const Eigen::Matrix3Xd& r, Eigen::Index left, Eigen::Index right)
      : held{left, right}, home{r.col(left), r.col(right)}, inward{(home[1] - home[0]).normalized()} {}
  [[nodiscard]] Eigen::Vector3d pull(int hand, double t, const auto& r) const {
    const double moved = 0.1 * std::min(t, 1.0);
    return k * (home[hand] + (hand == 0 ? moved : -moved) * inward - r.col(held[hand]));
  }
  void add(double t, const auto& y, auto& out) const {
    for (const int hand : {0, 1}) out.force.col(held[hand]) += pull(hand, t, y.r);
  }
  void add_jacobian(double /*t*/, const auto& /*y*/, auto& sink) const {
    for (const Eigen::Index i : held)
      for (Eigen::Index a = 3 * i; a < 3 * i + 3; ++a) sink.position(a, a, -k);
  }
};

int main(int argc, char** argv) {
  CommandLine options(argc, argv, {{"--mesh", ""}, {"--side", ""}});
  const std::string& file = options.own["--mesh"];
  const Mesh mesh = file.empty() ? grid(options.whole("--side", options.is_short ? 12 : 36, 2)) : read_off(file);
  const double t1 = options.is_short ? 0.3 : 1.5, dt = 0.01;                      // [s]
  const double stretch = 300, bend = 30, density = 0.2, g = 9.81, drag_rate = 4;  // [N/m] [kg/m²] [m/s²] [1/s]

  const Eigen::Matrix3Xd& start = mesh.vertices;
  const Eigen::VectorXd m = masses_of(mesh, density);
  Eigen::Index left = 0, right = 0;
  (start.row(1) - start.row(0)).maxCoeff(&left);
  (start.row(1) + start.row(0)).maxCoeff(&right);
  const Hands hands(start, left, right);
  const auto springs = phistep::spring_network<3>(springs_of(mesh, stretch, bend));
  const auto force =
      springs + phistep::Gravity{Eigen::Vector3d{0, 0, -g}} + phistep::LinearDrag{drag_rate * m.mean()} + hands;

  phistep::Motion cloth{start, Eigen::Matrix3Xd::Zero(3, start.cols())};
  phistep::Halving stepper{
      phistep::PhiStepper{cloth, force, phistep::backward_euler, phistep::mass(m),
                          phistep::newton<Cholesky>({.rtol = 1e-2, .atol = 1e-6, .max_iterations = 20})},
      10};

  std::printf("%ld particles, %zu springs, %g s in steps of %g s\n", static_cast<long>(start.cols()),
              springs.springs.size(), t1, dt);
  auto frames = options.file("cloth.xyz");
  const auto report = phistep::integrate(
      stepper, cloth, {0, t1}, phistep::fixed(dt), phistep::progress(std::cerr, t1),
      phistep::every(0.03, [&](double t, const auto& y) { phistep::write_extended_xyz(frames, t, y.r, y.v); }));
  std::cout << report;

  double longest = 0;
  for (const auto& s : springs.springs)
    longest = std::max(longest, (cloth.r.col(s.i) - cloth.r.col(s.j)).norm() / s.length - 1);
  std::printf(
      "The two hands carry %.3f N of %.3f N, the longest spring is stretched by %.1f %%, the hem hangs at %.3f m.\n",
      hands.pull(0, t1, cloth.r).z() + hands.pull(1, t1, cloth.r).z(), m.sum() * g, 100 * longest,
      cloth.r.row(2).minCoeff());
  auto triangles = options.file("cloth_triangles.csv");
  triangles << "a,b,c\n";
  for (const auto& t : mesh.triangles) triangles << t[0] << ',' << t[1] << ',' << t[2] << '\n';
  return report ? 0 : 1;
}
