// expect: extrapolated.* does not know the solution inside its steps: take at_times
#include <phistep/phistep.hpp>

int main() {
  const auto decay = [](const Eigen::Vector2d& y) -> Eigen::Vector2d { return -y; };
  Eigen::Vector2d y(1, 2);
  phistep::PhiStepper stepper{y, decay, phistep::extrapolated(phistep::forward_euler)};
  const auto look = [](double, const Eigen::Vector2d&) {};
#ifdef MUST_FAIL
  return phistep::integrate(stepper, y, {0, 1}, phistep::tolerance{}, phistep::sampled(0.1, look)) ? 0 : 1;
#else
  return phistep::integrate(stepper, y, {0, 1}, phistep::tolerance{}, phistep::at_times({0.1, 0.2}, look),
                            [](const auto& step) { return step.end().norm() > 0; })
             ? 0
             : 1;
#endif
}
