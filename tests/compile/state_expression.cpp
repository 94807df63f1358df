// expect: the state must be .*give an expression a name
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  Vec one = Vec::Ones(2);
#ifdef MUST_FAIL
  auto y = 2 * one;
#else
  Vec y = 2 * one;
#endif
  const auto decay = [](const Vec& x) -> Vec { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
