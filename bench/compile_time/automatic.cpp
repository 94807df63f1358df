// integrate without a stepper, on Robertson's reaction: five schemes are compiled.
#include <phistep/automatic.hpp>
#include <phistep/phistep.hpp>

#include <iostream>

using Vec = Eigen::VectorXd;

int main() {
  const auto robertson = [](const Vec& y) -> Vec {
    const double slow = 0.04 * y[0], fast = 1e4 * y[1] * y[2], quadratic = 3e7 * y[1] * y[1];
    return Vec{{fast - slow, slow - fast - quadratic, quadratic}};
  };
  Vec y{{1.0, 0.0, 0.0}};
  const auto report = phistep::integrate(y, robertson, {0.0, 40.0}, phistep::tolerance{.rtol = 1e-6, .atol = 1e-10});
  std::cout << report << '\n';
  return report ? 0 : 1;
}
