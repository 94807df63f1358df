// expect: the force returns a vector of another size
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
#ifdef MUST_FAIL
  using Result = Eigen::Vector3d;
#else
  using Result = Eigen::Vector2d;
#endif
  phistep::PhiStepper stepper{y, [](const Eigen::Vector2d&) -> Result { return Result::Zero(); },
                              phistep::forward_euler};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
