// expect: time comes last.* f.r., f.r, v. or f.r, v, t.
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
#ifdef MUST_FAIL
  auto force = [](double t, const Vec& r, const Vec&) -> Vec { return t * r; };  // time comes last
#else
  auto force = [](const Vec& r, const Vec&, double t) -> Vec { return t * r; };
#endif
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
