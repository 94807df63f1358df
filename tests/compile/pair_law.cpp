// expect: a pair law takes r.2 of several pairs at once and returns F/r
// errors: 8
#include <phistep/particles.hpp>

int main() {
  phistep::Particles<double, 3> atoms{Eigen::Matrix3Xd::Identity(3, 3)};
#ifdef MUST_FAIL
  const auto law = [](double r2) { return 1 / r2; };
#else
  const auto law = [](auto r2) { return 1 / r2; };
#endif
  phistep::PhiStepper stepper{atoms, phistep::Pairs{law, 2.5}, phistep::velocity_verlet};
  return stepper.step(atoms, 0, 0.1) ? 0 : 1;
}
