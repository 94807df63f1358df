// expect: all terms are seldom.k, term.
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
  const auto slow = [](const Vec& r) -> Vec { return -r; };
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, phistep::seldom(4, slow) + phistep::seldom(8, slow), phistep::velocity_verlet};
#else
  phistep::PhiStepper stepper{y, phistep::term(slow) + phistep::seldom(8, slow), phistep::velocity_verlet};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
