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

/// The fastest rate of an oscillation and of a decay, in any units, as a stepper of the scheme has the slopes.
inline void check_rates(auto scheme) {
  using Plain = Motion<Eigen::Vector2d>;
  for (const double unit : {1.0, 1e-9, 1e9}) {
    Plain y{Eigen::Vector2d(unit, 0), Eigen::Vector2d(0, 300 * unit)};
    Plain weight = y;
    ErrorNorm<Plain> norm;
    REQUIRE(norm.begin(tolerance{.rtol = 1e-2}, y));
    norm.weigh(y, weight);
    for (const double zeta : {0.0, 50.0}) {
      PhiStepper stepper{y, Oscillator{300, zeta}, scheme};
      SpectralRadius<Plain> radius{y};
      const double rho = radius([&](double t, const Plain& x, Plain& out) { return stepper.slope(t, x, out); }, 0.0, y,
                                weight, 1e-2, 8);
      // |λ| = ω undamped, ζω + √(ζ²−1) ω damped; differences of √u.
      const double exact = zeta == 0 ? 300 : 300 * (zeta + std::sqrt(zeta * zeta - 1));
      CHECK(rho == Approx(exact).epsilon(1e-3));
      CHECK(radius.turn() == Approx(zeta == 0 ? -1 : 1).epsilon(1e-3));
    }
  }
}

}  // namespace advise_cases
