// expect: writes its result into an argument, as Odeint.s f.y, dydt, t. does, wrap it in a lambda
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  phistep::Motion y{Vec::Ones(2), Vec::Zero(2)};
#ifdef MUST_FAIL
  auto force = [](const Vec& r, const Vec&, Vec& a, double) { a = -r; };
#else
  auto force = [](const Vec& r, const Vec&, double) -> Vec { return -r; };
#endif
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
