// expect: nodiscard|unused-result
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  phistep::PhiStepper stepper{y, [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r; },
                              phistep::forward_euler};
#ifdef MUST_FAIL
  stepper.step(y, 0, 0.1);
#else
  if (!stepper.step(y, 0, 0.1)) return 1;
#endif
}
