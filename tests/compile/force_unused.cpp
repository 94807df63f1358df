// expect: says uses_velocity = false or uses_time = false, and takes v or t
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

struct Drive {
#ifdef MUST_FAIL
  static constexpr bool uses_velocity = false;
#endif
  Vec operator()(const Vec& r, const Vec& v, double t) const { return std::sin(t) * Vec{1, 0} - r - 2 * v; }
};

int main() {
  phistep::Motion y{Vec{0, 1}, Vec{0, 0}};
  phistep::PhiStepper stepper{y, Drive{}, phistep::velocity_verlet};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
