// The atlas, first order, in short: the φ-method's endpoint form by Newton, and Halving at the poles. Stages, one
// solve, TR-BDF2: first_order.full.cpp. first_order*.stress.cpp goes through all schemes.

#include "stability/first_order_cases.hpp"

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
