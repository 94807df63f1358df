// expect: carry an acceleration from step to step, which the kicks of at.forward_euler, term. would make wrong
#include <phistep/phistep.hpp>

int main() {
  using Vec = Eigen::Vector2d;
  phistep::Motion<Vec> y{Vec(1, 2), Vec(0, 0)};
  const auto pull = [](const Vec& r) -> Vec { return -r; };
#ifdef MUST_FAIL
  const auto force = phistep::term(pull) + phistep::at(phistep::forward_euler, phistep::term(pull));
#else
  const auto force = phistep::term(pull) + phistep::term(pull);
#endif
  phistep::PhiStepper stepper{y, force, phistep::generalized_alpha(0.5)};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
