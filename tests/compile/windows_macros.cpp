// expect: min and max are macros here .windows.h.: define NOMINMAX
// errors: 2
// lines: 10
// quick: as it stands, too
#include <algorithm>  // as what is included before it usually brings it
#ifndef MUST_FAIL
#define NOMINMAX
#endif
#include "windows_like.hpp"
//
#include <phistep/all.hpp>

int main() {
  Eigen::Vector2d y{1, 0};
  const auto decay = [](const Eigen::Vector2d& x) -> Eigen::Vector2d { return -x; };
  phistep::PhiStepper stepper{y, decay, phistep::trapezoidal};
  return phistep::integrate(stepper, y, {0, 1}, phistep::tolerance{}) ? 0 : 1;
}
