// expect: a term of seldom.k, term. must ignore v
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
  const auto fast = [](const Vec& r) -> Vec { return -9 * r; };
#ifdef MUST_FAIL
  const auto slow = [](const Vec& r, const Vec& v) -> Vec { return -r - v; };
#else
  const auto slow = [](const Vec& r) -> Vec { return -r; };
#endif
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
  phistep::PhiStepper stepper{y, phistep::term(fast) + phistep::seldom(4, slow), phistep::velocity_verlet};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
