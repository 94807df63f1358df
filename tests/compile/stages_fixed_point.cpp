// expect: this scheme solves linear equations and iterates nothing: give it newton<LinearSolver>
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  const auto decay = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return -x; };
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, decay, phistep::rodas4, phistep::fixed_point()};
#else
  phistep::PhiStepper stepper{y, decay, phistep::rodas4, phistep::newton()};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
