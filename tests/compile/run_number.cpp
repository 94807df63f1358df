// expect: say how dt is chosen: fixed\(0.1\)
// lines: 20
#include <phistep/phistep.hpp>

using Vec = Eigen::VectorXd;

int main() {
  Vec y = Vec::Ones(2);
  const auto decay = [](const Vec& x) -> Vec { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal};
#ifdef MUST_FAIL
  phistep::Run run{stepper, y, {0, 1}, 0.1f};
#else
  phistep::Run run{stepper, y, {0, 1}, phistep::fixed(0.1)};
#endif
  return run.advance() ? 0 : 1;
}
