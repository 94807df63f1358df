// expect: radau factorizes complex matrices
#include <phistep/krylov.hpp>
#include <phistep/phistep.hpp>

int main() {
  Eigen::VectorXd y = Eigen::VectorXd::Ones(3);
  auto decay = [](const Eigen::VectorXd& x) -> Eigen::VectorXd { return -x; };
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, decay, phistep::radau, phistep::newton<phistep::MatrixFree<>>()};
#else
  phistep::PhiStepper stepper{y, decay, phistep::radau};
#endif
  static_cast<void>(stepper.step(y, 0, 0.1));
}
