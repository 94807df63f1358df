// expect: needs a force that ignores v
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

int main() {
#ifdef MUST_FAIL
  const auto force = [](const Vec& r, const Vec& v) -> Vec { return -r - 0.1 * v; };
#else
  const auto force = [](const Vec& r) -> Vec { return -r; };
#endif
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
  phistep::PhiStepper stepper{y, force, phistep::rkn1210};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
