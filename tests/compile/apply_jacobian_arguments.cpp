// expect: apply_jacobian must take
// errors: 8
#include <phistep/krylov.hpp>

struct Force {
  Eigen::VectorXd operator()(const Eigen::VectorXd& y) const { return -y; }
#ifdef MUST_FAIL
  Eigen::VectorXd apply_jacobian(const Eigen::VectorXd&, const Eigen::VectorXd& x) const { return -x; }
#else
  void apply_jacobian(double, const auto&, const auto& x, auto& out) const { out.rate -= x.y; }
#endif
};

int main() {
  Eigen::VectorXd y = Eigen::VectorXd::Ones(2);
  phistep::PhiStepper stepper{y, Force{}, phistep::trapezoidal, phistep::newton<phistep::MatrixFree<>>()};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
