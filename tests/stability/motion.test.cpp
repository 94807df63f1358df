// The atlas for motion, in short: the φ-method's pairs by Newton, and velocity Verlet. One solve, stages, and Verlet
// with drag: motion.full.cpp. motion*.stress.cpp goes through all schemes.

#include "stability/motion_cases.hpp"

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
