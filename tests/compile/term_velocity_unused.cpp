// expect: VelocityThatIsNotUsed
#include <phistep/phistep.hpp>

using Vec = Eigen::Vector2d;

struct Drag : phistep::ForceTerm {
#ifdef MUST_FAIL
  static constexpr bool uses_velocity = false;
#endif
  void add(double, const auto& y, auto& out) const { out.force -= y.r + 2 * y.v; }
};

int main() {
  phistep::Motion y{Vec{0, 1}, Vec{0, 0}};
  phistep::PhiStepper stepper{y, phistep::Gravity{Vec{0, -9.81}} + Drag{}, phistep::velocity_verlet};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
