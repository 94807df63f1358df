// expect: the stepper was made for a state of another type
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  Vec y = Vec::Ones(2);
  const auto decay = [](const Vec& x) -> Vec { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal};
#ifdef MUST_FAIL
  Eigen::Vector2d z = y;
#else
  Vec z = y;
#endif
  return phistep::integrate(stepper, z, {0, 1}, phistep::fixed(0.1)) ? 0 : 1;
}
