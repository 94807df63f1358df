// expect: the state must be .*make one number an Eigen::Vector<double, 1>
// lines: 20
#include <phistep/phistep.hpp>

#include <type_traits>

int main() {
#ifdef MUST_FAIL
  double y = 1;
#else
  Eigen::Vector<double, 1> y{1.0};
#endif
  phistep::PhiStepper stepper{y, [](const auto& x) { return std::remove_cvref_t<decltype(x)>(-x); },
                              phistep::trapezoidal};
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
