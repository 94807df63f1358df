// Van der Pol's oscillator, y'' = mu (1 - y^2) y' - y, from not stiff to very stiff: each for a period or so.
#include "problems/relaxation.hpp"

#include "rows.hpp"

namespace {
struct Oscillator {
  double mu;
  Eigen::Vector2d operator()(const Eigen::Vector2d& y) const { return {y[1], mu * (1 - y[0] * y[0]) * y[1] - y[0]}; }
  [[nodiscard]] Eigen::Matrix2d jacobian(const Eigen::Vector2d& y) const {
    return Eigen::Matrix2d{{0, 1}, {-2 * mu * y[0] * y[1] - 1, mu * (1 - y[0] * y[0])}};
  }
};
}  // namespace

void automatic::van_der_pol() {
  for (const double mu : {1.0, 10.0, 100.0, 1000.0}) {
    const double end = mu == 1 ? 20 : 2.2 * mu;
    const Eigen::Vector2d start(2, 0);
    Eigen::Vector2d exact = start;
    phistep::PhiStepper stepper{exact, Oscillator{mu}, phistep::radau};
    if (!phistep::integrate(stepper, exact, {0.0, end}, phistep::tolerance{.rtol = 1e-13, .atol = 1e-13})) continue;
    measure(problem(("Van der Pol, mu = " + std::to_string(static_cast<int>(mu))).c_str(), start, Oscillator{mu}, end,
                    exact, 1.0));
  }
  using P = problems::Relaxation;
  measure(problem("Van der Pol, epsilon = 1e-6", P::start(), P{}, P::end, P::exact(), 1.0));
}
