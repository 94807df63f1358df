// expect: phistep: .*Gravity|phistep: .*mo
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
#ifdef MUST_FAIL
  Vec y{1, 0};  // has neither v nor a force
#else
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
#endif
  phistep::PhiStepper stepper{y, phistep::Gravity{Vec(0, -9.81)}, phistep::forward_euler};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
