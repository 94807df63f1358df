// expect: needs a motion .r, v., not a first-order state
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
#ifdef MUST_FAIL
  Vec y{1, 0};
#else
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
#endif
  phistep::PhiStepper stepper{y, [](const Vec& r) -> Vec { return -r; }, phistep::rkn86};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
