// expect: radau needs a dense Jacobian
#include <phistep/phistep.hpp>
#include <phistep/sparse.hpp>

struct Chain {
  Eigen::VectorXd operator()(const Eigen::VectorXd& y) const { return -y; }
#ifdef MUST_FAIL
  Eigen::SparseMatrix<double> jacobian(const Eigen::VectorXd& y) const {
    Eigen::SparseMatrix<double> J(y.size(), y.size());
    J.setIdentity();
    return -J;
  }
#endif
};

int main() {
  Eigen::VectorXd y = Eigen::VectorXd::Ones(3);
  phistep::PhiStepper stepper{y, Chain{}, phistep::radau};
  static_cast<void>(stepper.step(y, 0, 0.1));
}
