// expect: the state must be .*give an expression a name
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  Vec y = Vec::Ones(2);
  const auto decay = [](const Vec& x) -> Vec { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal};
#ifdef MUST_FAIL
  return phistep::integrate(stepper, 2 * y, {0, 1}, phistep::fixed(0.1)) ? 0 : 1;
#else
  return phistep::integrate(stepper, y, {0, 1}, phistep::fixed(0.1)) ? 0 : 1;
#endif
}
