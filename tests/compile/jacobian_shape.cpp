// expect: must have one row and one column per unknown
#include <phistep/phistep.hpp>

struct Force {
  Eigen::Vector2d operator()(const Eigen::Vector2d& y) const { return -y; }
#ifdef MUST_FAIL
  using Matrix = Eigen::Matrix3d;
#else
  using Matrix = Eigen::Matrix2d;
#endif
  Matrix jacobian(const Eigen::Vector2d&) const { return -Matrix::Identity(); }
};

int main() {
  Eigen::Vector2d y{1, 0};
  phistep::PhiStepper stepper{y, Force{}, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
