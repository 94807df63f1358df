// A driver that tries eight schemes: six on Robertson's reaction, two on a pendulum.
#include <phistep/phistep.hpp>

#include <cmath>
#include <iostream>

using Vec = Eigen::VectorXd;

const phistep::tolerance accuracy{.rtol = 1e-6, .atol = 1e-10};

int run(auto y, auto force, auto scheme, double t1) {
  phistep::PhiStepper stepper{y, force, scheme};
  const auto report = phistep::integrate(stepper, y, {0.0, t1}, accuracy);
  std::cout << report << '\n';
  return report ? 0 : 1;
}

int main() {
  const auto robertson = [](const Vec& y) -> Vec {
    const double slow = 0.04 * y[0], fast = 1e4 * y[1] * y[2], quadratic = 3e7 * y[1] * y[1];
    return Vec{{fast - slow, slow - fast - quadratic, quadratic}};
  };
  const auto reaction = [&](auto scheme) { return run(Vec{{1.0, 0.0, 0.0}}, robertson, scheme, 40.0); };
  const auto pendulum = [](const Vec& r) -> Vec { return -r.array().sin(); };
  const auto motion = [&](auto scheme) { return run(phistep::Motion{Vec{{1.0}}, Vec{{0.0}}}, pendulum, scheme, 10.0); };
  return reaction(phistep::trapezoidal) + reaction(phistep::tr_bdf2) + reaction(phistep::rodas4) +
         reaction(phistep::rodas5p) + reaction(phistep::radau) + reaction(phistep::tsit5) + motion(phistep::rkn86) +
         motion(phistep::velocity_verlet);
}
