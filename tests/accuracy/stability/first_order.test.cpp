// The atlas, first order, in short: the φ-method's endpoint form by Newton, and Halving at the poles. Stages, one
// solve: the stress tier. first_order*.stress.cpp goes through all schemes.
#include <phistep/phistep.hpp>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "accuracy/stability/amplification.hpp"
#include "accuracy/stability/models.hpp"
#include "support/catch.hpp"
#if PHISTEP_STRESS
#include "accuracy/stability/survey.hpp"
#endif

using namespace stability;
using models::Number;
using models::Solve;

namespace {

const Vector zero = Vector::Zero();

/// `step` is PhiStepper's by phi(φ) or phi_stage(φ), Newton or affine.
[[maybe_unused]] Subject phi_subject(double phi, bool stage, bool affine, Stepping step) {
  const Solve how = affine ? Solve::once : Solve::iterated;
  Subject subject;
  subject.name = std::string(stage ? "phi_stage(" : "phi(") + std::to_string(phi) + (affine ? "), affine" : ")");
  subject.step = std::move(step);
  subject.R = [phi](Complex z) { return theory::phi(z, phi); };
  subject.model = [=](Complex z) {
    return stage ? models::phi_stage(Number{1}, z, phi, how) : models::phi_endpoint(Number{1}, z, phi, how);
  };
  if (phi > 0) subject.poles = {Complex{1 / static_cast<Real>(phi)}};
  return subject;
}

[[maybe_unused]] void check(const Subject& subject) {
  std::int64_t different = 0;
  Tally tally = over_grid(subject, 200, 1.0 / 16);
  const std::int64_t stable = tally.stable;
  tally += over_decades(subject, 2, different);
  tally += around_poles(subject);
  CAPTURE(subject.name, tally.cells, tally.explained, tally.worst, tally.first);
  CHECK(tally.unexplained == 0);
  CHECK(tally.harmed == 0);
  CHECK(different == 0);
  CHECK(stable > 0);
  CHECK(tally.worst > 0.001);  // the bound is one
}

}  // namespace

#if PHISTEP_FULL

TEST_CASE("atlas: a phi-step multiplies y by R(z) in every cell, endpoint and stage, Newton and affine") {
  for (const double phi : {0.0, 0.25, 0.5, 0.7, 1.0})
    check(phi_subject(phi, false, false, stepping(phistep::PhiStepper{zero, Decay{}, phistep::phi(phi)})));
}

TEST_CASE("atlas: at a pole a step is refused, and Halving does it as two") {
  Subject subject;
  subject.name = "Halving of backward_euler";
  subject.step = stepping(phistep::Halving{phistep::PhiStepper{zero, Decay{}, phistep::phi(1)}, 4});
  subject.R = [](Complex z) { return theory::phi(z, 1); };
  subject.model = [](Complex z) { return models::phi_endpoint(Number{1}, z, 1, Solve::iterated); };
  subject.poles = {Complex{1}};
  subject.instead = [](Complex z) { return theory::two_halves(z); };
  subject.model_instead = [](Complex z) { return models::two_halves(Number{1}, z, Solve::iterated); };
  Tally tally = around_poles(subject);
  CAPTURE(tally.first);
  CHECK(tally.unexplained == 0);
  CHECK(tally.explained["halved"] > 0);
  CHECK(subject.step({1, 0}, 1).outcome == Outcome::success);
  CHECK(std::abs(subject.step({1, 0}, 1).factor - Complex{4}) <= 16 * unit_roundoff);

  const Stepping plain = stepping(phistep::PhiStepper{zero, Decay{}, phistep::phi(1)});
  CHECK(plain({1, 0}, 1).outcome == Outcome::singular_matrix);
  CHECK(plain({1, 0}, 1).unharmed);
}

TEST_CASE("atlas: TR-BDF2 multiplies y by its R(z) in every cell") {
  Subject subject;
  subject.name = "tr_bdf2";
  subject.step = stepping(phistep::PhiStepper{zero, Decay{}, phistep::tr_bdf2});
  subject.R = [](Complex z) { return theory::tr_bdf2(z); };
  subject.model = [](Complex z) { return models::tr_bdf2(Number{1}, z, Solve::iterated); };
  subject.poles = {Complex{2 / (2 - std::sqrt(Real{2}))}};
  check(subject);
}

#elif PHISTEP_STRESS
// The atlas, first order, the φ-method and its kin: 200 × 200 cells of complex λΔt, |λΔt| from 1e-12 to 1e12, the
// neighbourhood of every pole; sectors, far ends, axes and orders. first_order_high.stress.cpp has the schemes of high order.

using namespace stability;

namespace {

const std::vector<Entry>& all() {
  static const std::vector<Entry> entries = [] {
    std::vector<Entry> made;
    subjects::add_phis(made);
    subjects::add_pairs_of_solves(made);
    return made;
  }();
  return entries;
}

}  // namespace

TEST_CASE("atlas, first order, phi-method: no cell is unexplained") {
  survey(all(), "atlas, phi-method: every cell as theory says");
}

TEST_CASE("atlas, first order, phi-method: sectors, far ends, axes, orders") {
  const auto of = [](const char* name) -> const Subject& { return named(all(), name); };
  // HW II, IV.3: the θ-method is A-stable from ½ on, |R(∞)| = (1 − φ)/φ.
  read_off(of("forward_euler"), {0, NAN, 1});
  read_off(of("trapezoidal"), {90, 1, 2});
  read_off(of("midpoint"), {90, 1, 2});
  read_off(of("backward_euler"), {90, 0, 1});
  read_off(of("phi(0.250000)"), {0, 3, 1});
  read_off(of("phi_stage(0.250000)"), {0, 3, 1});
  read_off(of("phi(0.750000)"), {90, 1.0 / 3, 1});
  read_off(of("from_spectral_radius(0.800000)"), {90, 0.8, 1});
  read_off(of("tr_bdf2"), {90, 0, 2});
  read_off(of("rannacher, first step"), {90, 0, 1});
  read_off(of("rannacher(0), later steps"), {90, 1, 2});
  read_off(of("split, phi = 0.500000"));
  figures::at_most(1e-6, std::abs(reach(of("phi(0.250000)"), 0) - 4), "atlas: phi < 1/2 is stable to 2/(1 - 2 phi)",
                   "|limit on the real axis - 4|, phi = 1/4");
}

#endif
