// expect: must be callable as f.y. or f.y, t.
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
  Vec y{1, 0};
#ifdef MUST_FAIL
  auto force = [](const Vec& r, const Vec&) -> Vec { return -r; };  // a motion's force
#else
  auto force = [](const Vec& r) -> Vec { return -r; };
#endif
  phistep::PhiStepper stepper{y, force, phistep::forward_euler};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
