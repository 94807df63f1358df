// expect: seldom.k, term. takes a term without at.scheme, term.
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
  const auto fast = [](const Vec& r) -> Vec { return -9 * r; };
  const auto slow = [](const Vec& r) -> Vec { return -r; };
#ifdef MUST_FAIL
  const auto force = phistep::term(fast) + phistep::at(phistep::forward_euler, phistep::seldom(4, slow));
#else
  const auto force = phistep::term(fast) + phistep::seldom(4, slow);
#endif
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
  phistep::PhiStepper stepper{y, force, phistep::velocity_verlet};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
