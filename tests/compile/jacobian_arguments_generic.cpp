// expect: must take the same arguments as the force itself
#include <phistep/phistep.hpp>

// A template's arguments are as wrong as any: differences must not take its place in silence.
struct Force {
  Eigen::Vector2d operator()(const Eigen::Vector2d& y, double t) const { return -t * y; }
#ifdef MUST_FAIL
  Eigen::Matrix2d jacobian(const auto&) const { return -Eigen::Matrix2d::Identity(); }
#else
  Eigen::Matrix2d jacobian(const auto&, double t) const { return -t * Eigen::Matrix2d::Identity(); }
#endif
};

int main() {
  Eigen::Vector2d y{1, 0};
  phistep::PhiStepper stepper{y, Force{}, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
