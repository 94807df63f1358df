// The atlas for motion, in short: the φ-method's pairs by Newton and by one solve, stages, and velocity Verlet.
// motion*.stress.cpp goes through all schemes.

#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>

#include "stability/motion.hpp"
#include "support/catch.hpp"

using namespace stability::motion;
using bounds::Law;
using bounds::Solve;
using stability::Real;

namespace {

const State rest{Vector{0}, Vector{0}};

Subject pair_subject(double f, double d, bool affine) {
  const Solve how = affine ? Solve::once : Solve::iterated;
  Subject subject;
  subject.name = "phi(" + std::to_string(f) + ", " + std::to_string(d) + (affine ? "), affine" : ")");
  if (affine) subject.step = stepping(phistep::PhiStepper{rest, phistep::affine(Spring<true>{}), phistep::phi(f, d)});
  else subject.step = stepping(phistep::PhiStepper{rest, Spring<true>{}, phistep::phi(f, d)});
  subject.R = [=](Real k, Real c) { return maps::pair(k, c, f, d); };
  subject.model = [=](const Law& law, const bounds::Motion& y) { return bounds::pair(law, y, f, d, how); };
  subject.symplectic = f + d == 1;
  return subject;
}

Tally check(const Subject& subject, double a_most = 8) {
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

}  // namespace

TEST_CASE("atlas: a pair moves an oscillator as Newmark's matrix says in every cell, Newton and affine") {
  for (const auto& [f, d] : {std::tuple{0., 0.},
                             {0., 1.},
                             {1., 0.},
                             {0.5, 0.5},
                             {1., 1.},
                             {0.25, 0.75},
                             {0.75, 0.25},
                             {0.6, 0.8},
                             {0.3, 0.4},
                             {0.5, 0.},
                             {0., 0.5},
                             {1., 0.5}})
    for (const bool affine : {false, true}) check(pair_subject(f, d, affine));
}

TEST_CASE("atlas: a pair with phi_force + phi_drift = 1 is stable up to 2/sqrt(1 - 4 phi_force phi_drift)") {
  for (const double f : {0.0, 0.125, 0.25, 0.375})
    CHECK(limit(pair_subject(f, 1 - f, false)) == Approx(2 / std::sqrt(1 - 4 * f * (1 - f))).epsilon(1e-7));
  CHECK(std::isinf(limit(pair_subject(0.5, 0.5, false))));
  CHECK(limit(pair_subject(0.25, 0.25, false)) == 0);  // never stable without damping: it gains energy
}

TEST_CASE("atlas: a stage form moves an oscillator as the endpoint form does") {
  for (const double phi : {0.0, 0.25, 0.5, 0.7, 1.0}) {
    Subject subject;
    subject.name = "phi_stage(" + std::to_string(phi) + ")";
    subject.step = stepping(phistep::PhiStepper{rest, Spring<true>{}, phistep::phi_stage(phi)});
    subject.R = [phi](Real k, Real c) { return maps::pair(k, c, phi, phi); };
    subject.model = [phi](const Law& law, const bounds::Motion& y) {
      return bounds::stage(law, y, phi, Solve::iterated);
    };
    subject.symplectic = phi == 0.5;
    check(subject);
  }
}

TEST_CASE("atlas: velocity Verlet is area-preserving without damping, and stable up to 2") {
  Subject subject;
  subject.name = "velocity_verlet";
  subject.step = stepping(phistep::PhiStepper{rest, Spring<false>{}, phistep::velocity_verlet});
  subject.R = [](Real k, Real c) { return maps::verlet(k, c); };
  subject.model = [](const Law& law, const bounds::Motion& y) { return bounds::verlet(law, y, 1, Solve::iterated); };
  subject.damped = false;
  subject.symplectic = true;
  check(subject);
  CHECK(limit(subject) == Approx(2).epsilon(1e-7));
  subject.name = "velocity_verlet, damped";
  subject.step = stepping(phistep::PhiStepper{rest, Spring<true>{}, phistep::velocity_verlet});
  subject.damped = true;
  check(subject);
}
