#include <phistep/phistep.hpp>

// Newton, a dense LU and a controlled run, all of it optimised: where g++ warns of what it believes uninitialised.
int main() {
  Eigen::VectorXd y = Eigen::VectorXd::Ones(4);
  const auto decay = [](const Eigen::VectorXd& x) -> Eigen::VectorXd { return -x.array().cube(); };
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal};
  return phistep::integrate(stepper, y, {0, 1}, phistep::tolerance{}) ? 0 : 1;
}
