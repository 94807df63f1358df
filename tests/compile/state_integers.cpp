// expect: the state's numbers must be float, double or long double
// lines: 12
#include <phistep/phistep.hpp>

int main() {
#ifdef MUST_FAIL
  using Vector = Eigen::VectorXi;
#else
  using Vector = Eigen::VectorXd;
#endif
  Vector y = Vector::Ones(2);
  phistep::PhiStepper stepper{y, [](const Vector& x) -> Vector { return -x; }, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
