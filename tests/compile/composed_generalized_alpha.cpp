// expect: composed.scheme. takes a scheme that is symmetric in time
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y(1, 2);
#ifdef MUST_FAIL
  const auto scheme = phistep::composed(phistep::generalized_alpha(0.5));
#else
  const auto scheme = phistep::composed(phistep::trapezoidal);
#endif
  phistep::PhiStepper stepper{y, [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return -x; }, scheme};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
