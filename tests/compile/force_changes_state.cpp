// expect: takes the state by non-const reference, take it by const reference
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  Vec y = Vec::Ones(2);
#ifdef MUST_FAIL
  auto force = [](Vec& x) -> Vec { return -x; };
#else
  auto force = [](const Vec& x) -> Vec { return -x; };
#endif
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
