// expect: after the scheme comes the mass, mass.2.0.
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  Vec y = Vec::Ones(2);
  const auto decay = [](const Vec& x) -> Vec { return -x; };
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal, 2.0};
#else
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal, phistep::capacity(2.0)};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
