// expect: must be callable as f.r_i., f.r_i, v_i. or f.r_i, v_i, t.
// errors: 8
#include <phistep/phistep.hpp>

int main() {
  using Eigen::Vector3d;
#ifdef MUST_FAIL
  auto f = [](const Vector3d& r, const Vector3d& v, double t, int) -> Vector3d { return t * (r + v); };
#else
  auto f = [](const Vector3d& r, const Vector3d& v, double t) -> Vector3d { return t * (r + v); };
#endif
  phistep::Motion<Eigen::VectorXd> y{Eigen::VectorXd::Ones(6), Eigen::VectorXd::Ones(6)};
  phistep::PhiStepper stepper{y, phistep::local<3>(f), phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
