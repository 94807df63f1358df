// expect: Sleeping (has none: it takes fixed steps alone|hasn't)
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

int main() {
  phistep::Particles<double, 2> y{Eigen::Matrix2Xd::Identity(2, 2)};
  phistep::Sleeping stepper{
      phistep::PhiStepper{y, phistep::Gravity{Eigen::Vector2d{0, -9.81}}, phistep::symplectic_euler},
      phistep::SleepOptions{.speed = 1e-3}};
#ifdef MUST_FAIL
  auto landed = phistep::event([](const auto& at) { return at.r(1, 0); });
  return phistep::integrate(stepper, y, {0.0, 1.0}, phistep::fixed(0.1), landed) ? 0 : 1;
#else
  return phistep::integrate(stepper, y, {0.0, 1.0}, phistep::fixed(0.1)) ? 0 : 1;
#endif
}
