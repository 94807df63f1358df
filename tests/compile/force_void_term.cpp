// expect: the force returns nothing
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  phistep::Motion y{Vec::Ones(2), Vec::Zero(2)};
#ifdef MUST_FAIL
  auto pull = [](const Vec& r) { static_cast<void>(-r); };
#else
  auto pull = [](const Vec& r) -> Vec { return -r; };
#endif
  auto force = phistep::LinearDrag{0.1} + phistep::term(pull);
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
