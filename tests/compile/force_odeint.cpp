// expect: writes its result into an argument, as Odeint.s f.y, dydt, t. does, wrap it in a lambda
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

void rate(const Vec& y, Vec& dydt, double t) { dydt = -t * y; }

int main() {
  Vec y = Vec::Ones(2), z = y;
  rate(y, z, 0);
#ifdef MUST_FAIL
  auto force = rate;
#else
  auto force = [](const Vec& x, double t) -> Vec {
    Vec dydt(x.size());
    rate(x, dydt, t);
    return dydt;
  };
#endif
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
