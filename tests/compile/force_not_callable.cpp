// expect: must be callable as f.y. or f.y, t.
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
#ifdef MUST_FAIL
  const double force = 3;
#else
  auto force = [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r; };
#endif
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
