// expect: the pressure needs the virial of this force between particles
#include <phistep/particles.hpp>

int main() {
  Eigen::Matrix3Xd r = Eigen::Matrix3Xd::Random(3, 4);
  phistep::Particles<double, 3> y{r};
  y.set_box(phistep::Box<double, 3>::periodic(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(9)));
  const auto pull = [](const Eigen::Matrix3Xd& x) -> Eigen::Matrix3Xd { return -x; };
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, phistep::term(pull), phistep::velocity_verlet};
#else
  phistep::PhiStepper stepper{y, phistep::Gravity{Eigen::Vector3d(0, 0, -1)}, phistep::velocity_verlet};
  static_cast<void>(pull);
#endif
  return phistep::pressure(stepper, y) > 0 ? 0 : 1;
}
