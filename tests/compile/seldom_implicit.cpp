// expect: seldom.k, term. makes inner steps of velocity_verlet
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
  const auto fast = [](const Vec& r) -> Vec { return -9 * r; };
  const auto slow = [](const Vec& r) -> Vec { return -r; };
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, phistep::term(fast) + phistep::seldom(4, slow), phistep::trapezoidal};
#else
  phistep::PhiStepper stepper{y, phistep::term(fast) + phistep::seldom(4, slow), phistep::velocity_verlet};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
