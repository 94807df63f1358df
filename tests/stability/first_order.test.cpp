// The atlas, first order, in short: the φ-method in both forms by Newton and by one solve, TR-BDF2, and Halving at the poles.
// first_order*.stress.cpp goes through all schemes.

#include <phistep/phistep.hpp>

#include <string>
#include <vector>

#include "stability/amplification.hpp"
#include "stability/models.hpp"
#include "support/catch.hpp"

using namespace stability;
using models::Number;
using models::Solve;

namespace {

const Vector zero = Vector::Zero();

Subject phi_subject(double phi, bool stage, bool affine) {
  const Solve how = affine ? Solve::once : Solve::iterated;
  Subject subject;
  subject.name = std::string(stage ? "phi_stage(" : "phi(") + std::to_string(phi) + (affine ? "), affine" : ")");
  const auto make = [&](auto scheme) {
    if (affine) return stepping(phistep::PhiStepper{zero, phistep::affine(Decay{}), scheme});
    return stepping(phistep::PhiStepper{zero, Decay{}, scheme});
  };
  subject.step = stage ? make(phistep::phi_stage(phi)) : make(phistep::phi(phi));
  subject.R = [phi](Complex z) { return theory::phi(z, phi); };
  subject.model = [=](Complex z) {
    return stage ? models::phi_stage(Number{1}, z, phi, how) : models::phi_endpoint(Number{1}, z, phi, how);
  };
  if (phi > 0) subject.poles = {Complex{1 / static_cast<Real>(phi)}};
  return subject;
}

void check(const Subject& subject) {
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

TEST_CASE("atlas: a phi-step multiplies y by R(z) in every cell, endpoint and stage, Newton and affine") {
  for (const double phi : {0.0, 0.25, 0.5, 0.7, 1.0})
    for (const bool stage : {false, true})
      for (const bool affine : {false, true}) check(phi_subject(phi, stage, affine));
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
