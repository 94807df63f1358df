// expect: must return phistep::MotionJacobian
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;
struct Force {
  Vec operator()(const Vec& r, const Vec& v) const { return -r - v; }
#ifdef MUST_FAIL
  Eigen::Matrix2d jacobian(const Vec&, const Vec&) const { return -Eigen::Matrix2d::Identity(); }
#else
  phistep::MotionJacobian<Eigen::Matrix2d> jacobian(const Vec&, const Vec&) const {
    return {-Eigen::Matrix2d::Identity(), -Eigen::Matrix2d::Identity()};
  }
#endif
};

int main() {
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
  phistep::PhiStepper stepper{y, Force{}, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
