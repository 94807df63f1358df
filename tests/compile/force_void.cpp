// expect: the force returns nothing
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  Vec y = Vec::Ones(2);
#ifdef MUST_FAIL
  auto force = [](const Vec& x) { static_cast<void>(-x); };
#else
  auto force = [](const Vec& x) -> Vec { return -x; };
#endif
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
