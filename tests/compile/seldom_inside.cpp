// expect: seldom.k, term. marks a term of the stepper's own sum
#include <phistep/phistep.hpp>

#include <functional>

using Vec = Eigen::Vector2d;

int main() {
  const auto fast = [](const Vec& r) -> Vec { return -9 * r; };
  const auto slow = [](const Vec& r) -> Vec { return -r; };
  auto sum = phistep::term(fast) + phistep::seldom(4, slow);
  phistep::Motion y{Vec{1, 0}, Vec{0, 0}};
#ifdef MUST_FAIL
  phistep::PhiStepper stepper{y, phistep::term(fast) + phistep::term(std::ref(sum)), phistep::velocity_verlet};
#else
  phistep::PhiStepper stepper{y, std::ref(sum), phistep::velocity_verlet};
#endif
  return stepper.step(y, 0, 0.1) ? 0 : 1;
}
