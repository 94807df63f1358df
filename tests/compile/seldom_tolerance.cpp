// expect: seldom.k, term. takes steps of one length, fixed.dt.
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
  const auto fast = [](const Vec& r) -> Vec { return -9 * r; };
  const auto slow = [](const Vec& r) -> Vec { return -r; };
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
  phistep::PhiStepper stepper{y, phistep::term(fast) + phistep::seldom(4, slow), phistep::velocity_verlet};
#ifdef MUST_FAIL
  const auto report = phistep::integrate(stepper, y, {0.0, 1.0}, phistep::tolerance{.rtol = 1e-6});
#else
  const auto report = phistep::integrate(stepper, y, {0.0, 1.0}, phistep::fixed(0.1));
#endif
  return report ? 0 : 1;
}
