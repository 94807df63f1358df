// expect: extrapolated.* does not know the solution inside its steps: take at_times
#include <phistep/phistep.hpp>

int main() {
  const auto decay = [](const Eigen::Vector2d& y) -> Eigen::Vector2d { return -y; };
  Eigen::Vector2d y(1, 2);
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, decay, phistep::extrapolated(phistep::forward_euler)};
#else
  phistep::PhiStepper stepper{y, decay, phistep::rodas5p};
#endif
  return phistep::integrate(stepper, y, {0, 1}, phistep::tolerance{},
                            [](const auto& step) { return step.at(step.t0() + step.dt() / 2).norm() > 0; })
             ? 0
             : 1;
}
