// expect: SpringNetwork needs particles as columns of a column-major matrix
#include <phistep/phistep.hpp>

#ifdef MUST_FAIL
using Positions = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;  // x x … y y …
#else
using Positions = Eigen::Matrix2Xd;  // x y x y …
#endif

int main() {
  phistep::Motion y{Positions(2, 2), Positions(2, 2)};
  y.r << 0, 1, 0, 0;
  y.v << 0, 0, 0, 0;
  phistep::PhiStepper stepper{y, phistep::spring_network<2>({{0, 1, 5.0, 0.5}}), phistep::velocity_verlet};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
