// The atlas, first order: the φ-method in both forms by Newton and by one solve, TR-BDF2. The quick half:
// first_order.test.cpp.

#include "stability/first_order_cases.hpp"

TEST_CASE("atlas: a phi-step multiplies y by R(z) in every cell, endpoint and stage, Newton and affine") {
  const auto both = [](double phi, bool stage, auto scheme) {
    check(phi_subject(phi, stage, false, stepping(phistep::PhiStepper{zero, Decay{}, scheme})));
    check(phi_subject(phi, stage, true, stepping(phistep::PhiStepper{zero, phistep::affine(Decay{}), scheme})));
  };
  for (const double phi : {0.0, 0.25, 0.5, 0.7, 1.0}) {
    both(phi, false, phistep::phi(phi));
    both(phi, true, phistep::phi_stage(phi));
  }
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
