// Integrate without choosing a scheme.
//
// Van der Pol's oscillator y'' = mu (1 - y^2) y' - y for mu = 1, 100, 10000, and a planet's orbit, each by one line. What is taken
// differs: an explicit pair where nothing is stiff, implicit schemes on the slow branches of the stiff ones.
#include <phistep/automatic.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <iostream>

using Vec = Eigen::Vector2d;

int main() {
  bool all_good = true;
  const phistep::tolerance wanted{.rtol = 1e-6, .atol = 1e-6};
  for (const double mu : {1.0, 100.0, 10000.0}) {
    const auto oscillator = [mu](const Vec& y) -> Vec { return {y[1], mu * (1 - y[0] * y[0]) * y[1] - y[0]}; };
    Vec y{2, 0};
    const auto report = phistep::integrate(y, oscillator, {0, 2 * mu}, wanted);
    std::cout << "Van der Pol, mu = " << mu << ": y = " << y[0] << " after " << report.statistics.steps << " steps, "
              << report.statistics.force_calls << " force calls, " << report.statistics.jacobians << " Jacobians\n"
              << report.schemes.message();
    all_good = all_good && report;
  }
  const auto gravity = [](const Vec& r) -> Vec { return -r / std::pow(r.norm(), 3); };
  phistep::Motion planet{Vec{1, 0}, Vec{0, 1}};
  const auto report = phistep::integrate(planet, gravity, {0, 2 * M_PI}, wanted);
  std::cout << "A circular orbit: back within " << (planet.r - Vec{1, 0}).norm() << " after "
            << report.statistics.force_calls << " force calls\n"
            << report.schemes.message();
  return all_good && report && (planet.r - Vec{1, 0}).norm() < 1e-4 ? 0 : 1;
}
