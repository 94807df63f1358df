#pragma once

// What the quick and the full half of extremes/subnormal share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>

#include "support/catch.hpp"

namespace subnormal_cases {

using namespace phistep;
template <class T>
using Three = Eigen::Matrix<T, 3, 1>;

struct Cubic {
  template <class T>
  Three<T> operator()(const Three<T>& x) const {
    return T(-0.7) * x - T(0.1) * x.array().cube().matrix();
  }
};

/// Steps until nothing but some of the least numbers is left, and on.
template <class S, class F, class... Options>
void check(const char* name, S y, F f, Options... options) {
  using T = ScalarOf<S>;
  PhiStepper stepper{y, f, options...};
  INFO(name);
  int steps = 0;
  for (; steps < 6000; ++steps) {
    const StepReport report = stepper.step(y, static_cast<T>(0.5) * static_cast<T>(steps), static_cast<T>(0.5));
    if (!report) FAIL("step " << steps << ": " << report.message());
  }
  double largest = 0;
  for_each_block(
      [&](auto, const auto& block) { largest = std::max(largest, static_cast<double>(block.cwiseAbs().maxCoeff())); },
      Blocks<S>::all(y));
  CHECK(largest <= 30 * static_cast<double>(std::numeric_limits<T>::denorm_min()));
}

}  // namespace subnormal_cases
