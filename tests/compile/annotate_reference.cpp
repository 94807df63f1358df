// expect: annotate the force itself, and take std::ref of that
// lines: 40
#include <phistep/phistep.hpp>

#include <functional>

struct Spring {
  Eigen::Vector2d operator()(const Eigen::Vector2d& r) const { return -r; }
  Eigen::Matrix2d jacobian(const Eigen::Vector2d&) const { return -Eigen::Matrix2d::Identity(); }
};

int main() {
  Eigen::Vector2d y{1, 0};
  Spring spring;
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, phistep::affine(std::ref(spring)), phistep::trapezoidal};
#else
  auto affine = phistep::affine(spring);
  phistep::PhiStepper stepper{y, std::ref(affine), phistep::trapezoidal};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
