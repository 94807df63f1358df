#pragma once

// What both halves of stability/first_order need.

#include <phistep/phistep.hpp>

#include <string>
#include <utility>
#include <vector>

#include "stability/amplification.hpp"
#include "stability/models.hpp"
#include "support/catch.hpp"

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
