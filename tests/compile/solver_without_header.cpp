// expect: a linear solver of one.s own needs a sparse Jacobian, and <phistep/sparse.hpp>|has a sparse Jacobian: #include <phistep/sparse.hpp>
#include <Eigen/SparseCholesky>
#include <phistep/phistep.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  auto force = [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r; };
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal,
                              phistep::newton<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>()};
#else
  phistep::PhiStepper stepper{y, force, phistep::trapezoidal, phistep::newton()};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
