// The atlas for motion, in short: the φ-method's pairs by Newton, and velocity Verlet. One solve, stages, and Verlet
// with drag: the stress tier. motion*.stress.cpp goes through all schemes.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "accuracy/stability/motion.hpp"
#include "support/catch.hpp"
#if PHISTEP_STRESS
#include "accuracy/stability/motion_survey.hpp"
#endif

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

#if PHISTEP_FULL

TEST_CASE("atlas: a pair moves an oscillator as Newmark's matrix says in every cell, Newton and affine") {
  for (const auto& [f, d] : pairs) check(pair_subject(f, d));
}

TEST_CASE("atlas: a pair with phi_force + phi_drift = 1 is stable up to 2/sqrt(1 - 4 phi_force phi_drift)") {
  for (const double f : {0.0, 0.125, 0.25, 0.375})
    CHECK(limit(pair_subject(f, 1 - f)) == Approx(2 / std::sqrt(1 - 4 * f * (1 - f))).epsilon(1e-7));
  CHECK(std::isinf(limit(pair_subject(0.5, 0.5))));
  CHECK(limit(pair_subject(0.25, 0.25)) == 0);  // never stable without damping: it gains energy
}

TEST_CASE("atlas: velocity Verlet is area-preserving without damping, and stable up to 2") {
  const Subject subject =
      verlet_subject(stepping(phistep::PhiStepper{rest, Spring<false>{}, phistep::velocity_verlet}));
  check(subject);
  CHECK(limit(subject) == Approx(2).epsilon(1e-7));
}

#elif PHISTEP_STRESS
// The atlas for motion: pairs, stages, Verlet and what is made of it. motion_stiff.stress.cpp has the stiff schemes.

using namespace stability::motion;

namespace {

const std::vector<Entry>& all() {
  static const std::vector<Entry> entries = [] {
    std::vector<Entry> made;
    subjects::add_pairs(made);
    subjects::add_verlet(made);
    subjects::add_compositions(made);
    subjects::add_nystrom(made);
    return made;
  }();
  return entries;
}

}  // namespace

TEST_CASE("atlas, motion: no cell of a pair, a composition or a Nystrom pair is unexplained") {
  survey(all(), "atlas, motion: every cell as theory says");
}

TEST_CASE("atlas, motion: how far an oscillation doesn't grow") {
  // Of the compositions: from the traces of their published coefficients' shears, evaluated elsewhere.
  const std::map<std::string, double> known{{"velocity_verlet", 2},       {"symplectic_euler", 2},
                                            {"srkn6b", 3.16346},          {"srkn11b", 3.14143},
                                            {"forward_euler", 0},         {"composed(velocity_verlet)", 3.09644},
                                            {"backward_euler", HUGE_VAL}, {"trapezoidal", HUGE_VAL}};
  for (const Entry& entry : all()) {
    const auto found = known.find(entry.subject.name);
    read_off(entry.subject, found == known.end() ? NAN : found->second);
  }
}

#endif
