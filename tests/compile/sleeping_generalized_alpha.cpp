// expect: carry an acceleration from step to step, which would move who sleeps
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

int main() {
  phistep::Particles<double, 2> y{Eigen::Matrix2Xd::Identity(2, 2)};
#ifdef MUST_FAIL
  const auto scheme = phistep::hht(-0.1);
#else
  const auto scheme = phistep::trapezoidal;
#endif
  phistep::Sleeping stepper{phistep::PhiStepper{y, phistep::Gravity{Eigen::Vector2d{0, -9.81}}, scheme},
                            phistep::SleepOptions{.speed = 1e-3}};
  return phistep::integrate(stepper, y, {0.0, 1.0}, phistep::fixed(0.1)) ? 0 : 1;
}
