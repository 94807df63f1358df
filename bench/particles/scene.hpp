/// @file
/// A start that two programs can read: positions and velocities, as plain columns and as a LAMMPS data file.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>
#include <string>

namespace bench {

/// Particles of unit mass in a periodic box [0, side)³.
struct Scene {
  double side = 0;
  Eigen::Matrix3Xd r, v;
  Eigen::VectorXi type{};  ///< from 0 on; empty: one type
  [[nodiscard]] Eigen::Index size() const { return r.cols(); }
};

/// The Lennard-Jones melt of LAMMPS' bench/in.lj in reduced units: a face-centred lattice of ρ = 0.8442 with
/// cells³ · 4 atoms, random velocities without momentum, 2 E_kin/(3N − 3) = 1.44 to rounding.
[[nodiscard]] inline Scene melt_start(int cells, double density = 0.8442, double temperature = 1.44) {
  const double a = std::cbrt(4 / density);
  Scene scene{cells * a, {3, 4L * cells * cells * cells}, {}, {}};
  const double corners[4][3] = {{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}};
  Eigen::Index n = 0;
  for (int k = 0; k < cells; ++k)
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i)
        for (const auto& c : corners) scene.r.col(n++) << (i + c[0]) * a, (j + c[1]) * a, (k + c[2]) * a;
  std::mt19937_64 random(87287);
  std::normal_distribution<double> normal;
  scene.v = Eigen::Matrix3Xd::NullaryExpr(3, n, [&] { return normal(random); });
  scene.v.colwise() -= scene.v.rowwise().mean().eval();
  scene.v *= std::sqrt(temperature * (3.0 * static_cast<double>(n) - 3) / scene.v.squaredNorm());
  return scene;
}

/// 17 digits, so that the reader has the same bits.
inline void write_lammps(const Scene& scene, const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (!file) throw std::runtime_error("cannot write " + path);
  const int types = scene.type.size() == 0 ? 1 : scene.type.maxCoeff() + 1;
  std::fprintf(file, "start of a benchmark\n\n%td atoms\n%d atom types\n\n", scene.size(), types);
  for (const char* axis : {"xlo xhi", "ylo yhi", "zlo zhi"}) std::fprintf(file, "0 %.17g %s\n", scene.side, axis);
  std::fprintf(file, "\nMasses\n\n");
  for (int k = 1; k <= types; ++k) std::fprintf(file, "%d 1\n", k);
  std::fprintf(file, "\nAtoms # atomic\n\n");
  for (Eigen::Index i = 0; i < scene.size(); ++i)
    std::fprintf(file, "%td %d %.17g %.17g %.17g\n", i + 1, types == 1 ? 1 : scene.type[i] + 1, scene.r(0, i),
                 scene.r(1, i), scene.r(2, i));
  std::fprintf(file, "\nVelocities\n\n");
  for (Eigen::Index i = 0; i < scene.size(); ++i)
    std::fprintf(file, "%td %.17g %.17g %.17g\n", i + 1, scene.v(0, i), scene.v(1, i), scene.v(2, i));
  if (std::fclose(file) != 0) throw std::runtime_error("cannot write " + path);
}

}  // namespace bench
