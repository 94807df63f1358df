// expect: Motion\{r, v\} takes Eigen vectors
// lines: 20
#include <phistep/phistep.hpp>

int main() {
#ifdef MUST_FAIL
  phistep::Motion y{1.0, 0.0};
#else
  phistep::Motion y{Eigen::Vector<double, 1>{1.0}, Eigen::Vector<double, 1>{0.0}};
#endif
  phistep::PhiStepper stepper{y, [](const auto& r) { return (-r).eval(); }, phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
