// expect: at.scheme, term. takes forward_euler
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
  const auto spring = [](const Vec& r) -> Vec { return -r; };
#ifdef MUST_FAIL
  const auto force = phistep::term(spring) + phistep::at(phistep::backward_euler, spring);
#else
  const auto force = phistep::term(spring) + phistep::at(phistep::forward_euler, spring);
#endif
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
