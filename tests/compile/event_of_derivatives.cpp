// expect: an event's time depends on what numbers with derivatives are differentiated by
#include <phistep/phistep.hpp>
#include <unsupported/Eigen/AutoDiff>

int main() {
#ifdef MUST_FAIL
  using Number = Eigen::AutoDiffScalar<Eigen::Vector2d>;
#else
  using Number = double;
#endif
  using Vector = Eigen::Matrix<Number, 2, 1>;
  Vector y = Vector::Constant(Number(1.0));
  phistep::PhiStepper stepper{y, [](const Vector& x) -> Vector { return -x; }, phistep::tsit5};
  auto event = phistep::event([](const Vector&) { return 0.5; });
  return phistep::integrate(stepper, y, {0.0, 1.0}, phistep::fixed(0.1), event) ? 0 : 1;
}
