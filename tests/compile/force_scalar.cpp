// expect: the force returns another scalar type
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
#ifdef MUST_FAIL
  using Result = Eigen::Vector2f;
#else
  using Result = Eigen::Vector2d;
#endif
  phistep::PhiStepper stepper{y, [](const Eigen::Vector2d& r) -> Result { return r.cast<Result::Scalar>(); },
                              phistep::forward_euler};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
