// expect: the state must be an Eigen vector .*a Map of your array
// lines: 20
#include <phistep/phistep.hpp>

#include <vector>

using Vec = Eigen::VectorXd;

int main() {
  Vec y = Vec::Ones(2);
  const auto decay = [](const Vec& x) -> Vec { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal};
#ifdef MUST_FAIL
  std::vector<double> z{1, 1};
#else
  Vec z = y;
#endif
  return phistep::integrate(stepper, z, {0, 1}, phistep::fixed(0.1)) ? 0 : 1;
}
