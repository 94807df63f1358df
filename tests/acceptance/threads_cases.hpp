#pragma once

// The same scene with one thread and with more: what both halves of acceptance/threads need.

#include <omp.h>
#include <phistep/particles.hpp>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "support/catch.hpp"

using namespace phistep;
using Atoms = Particles<double, 3>;

namespace {

/// A fluid of n³ atoms at LAMMPS' melt's density and temperature, periodic.
Atoms fluid(int n) {
  const double a = std::cbrt(1 / 0.8442);
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1.2);
  Eigen::Matrix3Xd r(3, n * n * n), v(3, n * n * n);
  for (Index k = 0; k < r.cols(); ++k) {
    r.col(k) << static_cast<double>(k % n), static_cast<double>(k / n % n), static_cast<double>(k / (n * n));
    for (int b = 0; b < 3; ++b) v(b, k) = normal(random);
  }
  Atoms atoms{a * r, v.colwise() - v.rowwise().mean()};
  atoms.set_box(Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(n * a)));
  return atoms;
}

/// Steps `atoms` so many times. Checks stand outside of the template.
using Steps = std::function<std::string(Atoms& atoms, int steps, double dt)>;
Steps by(auto make) {
  return [make](Atoms& atoms, int steps, double dt) -> std::string {
    auto stepper = make(atoms);
    for (int n = 0; n < steps; ++n)
      if (const StepReport report = stepper.step(atoms, dt * n, dt); !report) return report.message();
    return "";
  };
}
/// The end of `steps` steps with so many threads.
Atoms run(int threads, Atoms atoms, int steps, double dt, const Steps& make) {
  omp_set_num_threads(threads);
  const std::string trouble = make(atoms, steps, dt);
  if (!trouble.empty()) FAIL(trouble);
  return atoms;
}
void check(const Atoms& start, int steps, double dt, const Steps& make) {
  const Atoms one = run(1, start, steps, dt, make);
  for (const int threads : {2, 3}) {
    const Atoms more = run(threads, start, threads == 2 ? steps : steps / 10, dt, make);
    const Atoms same = threads == 2 ? one : run(1, start, steps / 10, dt, make);
    CHECK(more.r == same.r);
    CHECK(more.v == same.v);
  }
}

}  // namespace
