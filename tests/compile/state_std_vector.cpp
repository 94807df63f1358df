// expect: the state must be an Eigen vector .*a Map of your array
// lines: 20
#include <phistep/phistep.hpp>

#include <vector>

using Vec = Eigen::VectorXd;

int main() {
  std::vector<double> numbers{1, 2};
#ifdef MUST_FAIL
  std::vector<double>& y = numbers;
#else
  Eigen::Map<Vec> y{numbers.data(), 2};
#endif
  const auto decay = [](const Vec& x) -> Vec { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
