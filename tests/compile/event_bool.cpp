// expect: the function of an event must return a number that changes its sign
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  phistep::PhiStepper stepper{y, [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r; },
                              phistep::forward_euler};
#ifdef MUST_FAIL
  auto half = phistep::event([](const Eigen::Vector2d& r) { return r[0] < 0.5; });
#else
  auto half = phistep::event([](const Eigen::Vector2d& r) { return r[0] - 0.5; });
#endif
  return phistep::integrate(stepper, y, {0, 1}, phistep::fixed(0.1), half) ? 0 : 1;
}
