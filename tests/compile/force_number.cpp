// expect: the force must return an Eigen vector
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  Vec y = Vec::Ones(2);
#ifdef MUST_FAIL
  auto force = [](const Vec& x) { return -x[0]; };
#else
  auto force = [](const Vec& x) -> Vec { return -x; };
#endif
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
