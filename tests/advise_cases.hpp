#pragma once

// What advise.test.cpp and its long half share.

#include <phistep/advise.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <sstream>
#include <string>

#include "support/catch.hpp"

namespace advise_cases {

using namespace phistep;

/// A scene of n unknowns, without its stiffness.
inline AdvisedProblem scene(std::int64_t n, double rtol, Structure structure = Structure::dense) {
  AdvisedProblem s;
  s.unknowns = n;
  s.rtol = rtol;
  s.structure = structure;
  s.has_jacobian = true;
  return s;
}
inline Stiffness stiffness(bool is_stiff) {
  Stiffness s;
  s.known = true;
  s.is_stiff = is_stiff;
  s.covered = 1;
  s.steps = 100;
  s.rate = s.dt = 1;
  return s;
}
inline std::string choice(const AdvisedProblem& s, bool is_stiff) { return decide(s, stiffness(is_stiff)).scheme; }

/// r'' = −ω² r − 2ζω v
struct Oscillator {
  double omega, zeta;
  using Vec = Eigen::Vector2d;
  Vec operator()(const Vec& r, const Vec& v) const { return -omega * omega * r - 2 * zeta * omega * v; }
};

}  // namespace advise_cases
