// A first program: a spring, by the trapezoidal rule.
#include <phistep/phistep.hpp>

#include <iostream>

using Vec = Eigen::Vector2d;

int main() {
  auto spring = [](const Vec& r) -> Vec { return -400.0 * r; };
  phistep::Motion state{Vec{1, 0}, Vec{0, 0}};
  phistep::PhiStepper stepper{state, spring, phistep::trapezoidal, phistep::mass(2.0)};
  for (int n = 0; n < 1000; ++n)
    if (auto step = stepper.step(state, 0.01 * n, 0.01); !step) {
      std::cerr << step.message() << '\n';
      return 1;
    }
}
