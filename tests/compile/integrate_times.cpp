// expect: the times of a run go in braces
// lines: 12
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  phistep::PhiStepper stepper{y, [](const Eigen::Vector2d& u) -> Eigen::Vector2d { return -u; }, phistep::trapezoidal};
#ifdef MUST_FAIL
  return phistep::integrate(stepper, y, 0, 1, phistep::fixed(0.1)) ? 0 : 1;
#else
  return phistep::integrate(stepper, y, {0, 1}, phistep::fixed(0.1)) ? 0 : 1;
#endif
}
