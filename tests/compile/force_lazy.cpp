// expect: the force returns a lazy Eigen expression
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  Vec y = Vec::Ones(2);
#ifdef MUST_FAIL
  auto force = [](const Vec& r) { return -2.0 * r; };  // refers to a temporary that is gone
#else
  auto force = [](const Vec& r) -> Vec { return -2.0 * r; };
#endif
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
