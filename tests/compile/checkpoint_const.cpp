// expect: saving forgets Jacobians and factors: a stepper or run that has them can.t be const here
// flags: -fno-rtti
#include <phistep/all.hpp>

#include <utility>

int main() {
  Eigen::Vector2d y{1, 0};
  const auto decay = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return -x; };
  phistep::PhiStepper implicit{y, decay, phistep::backward_euler};
  phistep::PhiStepper other{y, decay, phistep::forward_euler};
  phistep::save_checkpoint("run.checkpoint", std::as_const(other), std::as_const(y));
#ifdef MUST_FAIL
  phistep::save_checkpoint("run.checkpoint", std::as_const(implicit));
#else
  phistep::save_checkpoint("run.checkpoint", implicit);
#endif
}
