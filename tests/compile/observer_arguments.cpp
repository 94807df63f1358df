// expect: an observer must be callable as observer.t, state.
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  phistep::PhiStepper stepper{y, [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r; },
                              phistep::forward_euler};
#ifdef MUST_FAIL
  auto look = [](const Eigen::Vector2d&) {};
#else
  auto look = [](double, const Eigen::Vector2d&) {};
#endif
  return phistep::integrate(stepper, y, {0, 1}, phistep::fixed(0.1), look) ? 0 : 1;
}
