// expect: a member function needs its object: give a lambda
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

struct System {
  double k = 2;
  Vec rate(const Vec& y) const { return -k * y; }
};

int main() {
  Vec y = Vec::Ones(2);
  System system;
#ifdef MUST_FAIL
  auto force = &System::rate;
#else
  auto force = [&system](const Vec& x) -> Vec { return system.rate(x); };
#endif
  y *= system.k;
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
