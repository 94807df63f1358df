#pragma once

// What both halves of stability/motion need.

#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>

#include "stability/motion.hpp"
#include "support/catch.hpp"

using namespace stability::motion;
using bounds::Law;
using bounds::Solve;
using stability::Real;

namespace {

const State rest{Vector{0}, Vector{0}};

// (φ_force, φ_drift)
constexpr std::tuple<double, double> pairs[] = {{0., 0.},   {0., 1.},     {1., 0.},     {0.5, 0.5},
                                                {1., 1.},   {0.25, 0.75}, {0.75, 0.25}, {0.6, 0.8},
                                                {0.3, 0.4}, {0.5, 0.},    {0., 0.5},    {1., 0.5}};

/// `step` is PhiStepper's by phi(f, d), Newton or affine.
[[maybe_unused]] Subject pair_subject(double f, double d, bool affine, Stepping step) {
  const Solve how = affine ? Solve::once : Solve::iterated;
  Subject subject;
  subject.name = "phi(" + std::to_string(f) + ", " + std::to_string(d) + (affine ? "), affine" : ")");
  subject.step = std::move(step);
  subject.R = [=](Real k, Real c) { return maps::pair(k, c, f, d); };
  subject.model = [=](const Law& law, const bounds::Motion& y) { return bounds::pair(law, y, f, d, how); };
  subject.symplectic = f + d == 1;
  return subject;
}

[[maybe_unused]] Subject pair_subject(double f, double d) {
  return pair_subject(f, d, false, stepping(phistep::PhiStepper{rest, Spring<true>{}, phistep::phi(f, d)}));
}

[[maybe_unused]] Tally check(const Subject& subject, double a_most = 8) {
  std::int64_t different = 0;
  Tally tally = over_grid(subject, 100, a_most);
  tally += over_decades(subject, 4, different);
  CAPTURE(subject.name, tally.cells, tally.explained, tally.worst, tally.first);
  CHECK(tally.unexplained == 0);
  CHECK(tally.harmed == 0);
  CHECK(different == 0);
  CHECK(tally.worst > 0.001);
  return tally;
}

/// `step` is PhiStepper's by velocity Verlet, without damping.
[[maybe_unused]] Subject verlet_subject(Stepping step) {
  Subject subject;
  subject.name = "velocity_verlet";
  subject.step = std::move(step);
  subject.R = [](Real k, Real c) { return maps::verlet(k, c); };
  subject.model = [](const Law& law, const bounds::Motion& y) { return bounds::verlet(law, y, 1, Solve::iterated); };
  subject.damped = false;
  subject.symplectic = true;
  return subject;
}

}  // namespace
