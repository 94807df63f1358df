// The atlas for motion: the φ-method's pairs by one solve too, stages, velocity Verlet with drag. The quick half:
// motion.test.cpp.

#include "stability/motion_cases.hpp"

TEST_CASE("atlas: a pair moves an oscillator as Newmark's matrix says in every cell, Newton and affine") {
  for (const auto& [f, d] : pairs) {
    check(pair_subject(f, d));
    check(pair_subject(f, d, true,
                       stepping(phistep::PhiStepper{rest, phistep::affine(Spring<true>{}), phistep::phi(f, d)})));
  }
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
  Subject subject = verlet_subject(stepping(phistep::PhiStepper{rest, Spring<true>{}, phistep::velocity_verlet}));
  subject.name = "velocity_verlet, damped";
  subject.damped = true;
  check(subject);
}
