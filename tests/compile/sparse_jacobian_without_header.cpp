// expect: this force has a sparse Jacobian: #include <phistep/sparse.hpp>
#include <phistep/phistep.hpp>

int main() {
  phistep::Motion y{Eigen::Vector4d(0, 0, 1, 0), Eigen::Vector4d(0, 0, 0, 0)};
  auto springs = phistep::spring_network<2>({{0, 1, 5.0, 0.5}});
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, springs, phistep::trapezoidal};
#else
  phistep::PhiStepper stepper{y, springs, phistep::velocity_verlet};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
