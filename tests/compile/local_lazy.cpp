// expect: returns a lazy Eigen expression
// errors: 8
#include <phistep/phistep.hpp>

int main() {
  using Eigen::Vector3d;
#ifdef MUST_FAIL
  auto f = [](const Vector3d& r) { return -r; };
#else
  auto f = [](const Vector3d& r) -> Vector3d { return -r; };
#endif
  phistep::Motion<Eigen::VectorXd> y{Eigen::VectorXd::Ones(6), Eigen::VectorXd::Ones(6)};
  phistep::PhiStepper stepper{y, phistep::local<3>(f), phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
