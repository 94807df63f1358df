// expect: a checkpoint names its parts. types: compile without -fno-rtti
// flags: -fno-rtti
#include <phistep/all.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  const auto decay = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::rodas4};
  phistep::Run run{stepper, y, {0, 1}, phistep::tolerance{}};
  if (!run.finish()) return 1;
#ifdef MUST_FAIL
  phistep::save_checkpoint("run.checkpoint", run);
#endif
}
