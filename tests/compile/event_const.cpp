// expect: an event keeps the times at which it occurred, so it can.t be const
// errors: 3
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  const auto decay = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::forward_euler};
#ifdef MUST_FAIL
  const auto half = phistep::event([](const Eigen::Vector2d& x) { return x[0] - 0.5; });
#else
  auto half = phistep::event([](const Eigen::Vector2d& x) { return x[0] - 0.5; });
#endif
  return phistep::integrate(stepper, y, {0, 1}, phistep::fixed(0.1), half) ? 0 : 1;
}
