// expect: would fill a copy: write std::ref.recorder.
// errors: 1
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  const auto decay = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::forward_euler};
  phistep::Recorder<Eigen::Vector2d> recorder;
#ifdef MUST_FAIL
  return phistep::integrate(stepper, y, {0, 1}, phistep::fixed(0.1), phistep::every(0.2, recorder)) ? 0 : 1;
#else
  return phistep::integrate(stepper, y, {0, 1}, phistep::fixed(0.1), phistep::every(0.2, std::ref(recorder))) ? 0 : 1;
#endif
}
