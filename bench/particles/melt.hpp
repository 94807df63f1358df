/// @file
/// The Lennard-Jones melt: what it must give, and who computes it.
#pragma once

#include <memory>
#include <string>

#include "cells.hpp"
#include "scene.hpp"

namespace bench {

constexpr double melt_cutoff = 2.5, melt_dt = 0.005;

/// What LAMMPS prints, per atom and in reduced units, from all pairs of a cell grid.
struct Thermo {
  double temperature, pair_energy, total_energy, pressure;
};
[[nodiscard]] inline Thermo thermo_of(const Eigen::Matrix3Xd& r, const Eigen::Matrix3Xd& v, double side) {
  double energy = 0, virial = 0;
  for_each_pair(r, side, melt_cutoff, [&](auto, auto, const Eigen::Vector3d& d) {
    const double s6 = std::pow(d.squaredNorm(), -3);
    energy += 4 * s6 * (s6 - 1);
    virial += 48 * s6 * (s6 - 0.5);  // d·F
  });
  const double n = static_cast<double>(r.cols()), twice_kinetic = v.squaredNorm();
  return {twice_kinetic / (3 * n - 3), energy / n, energy / n + twice_kinetic / (2 * n),
          (twice_kinetic + virial) / (3 * side * side * side)};
}

/// A kernel written by hand: pair forces from a list that stands, nothing else. Its list is built with it.
struct HandForce {
  virtual ~HandForce() = default;
  virtual void compute() = 0;
  [[nodiscard]] virtual Eigen::Matrix3Xd forces() const = 0;
  [[nodiscard]] virtual std::string name() const = 0;
};
[[nodiscard]] std::unique_ptr<HandForce> hand_force(const Scene& scene, double skin);

}  // namespace bench
