// Every scheme that takes any state, on a circle that is pulled to radius 1: polynomials, not stiff. Under a tolerance where
// the scheme estimates its error, else in equal steps.
#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <string>

#include "pinned/pinned.hpp"

namespace {

using namespace phistep;
using Eigen::Vector2d;

/// r' = r (1 − r²), once round in 2π.
struct Circle {
  Vector2d operator()(const Vector2d& y) const {
    const double pull = 1 - y.squaredNorm();
    return {pull * y[0] - y[1], pull * y[1] + y[0]};
  }
  [[nodiscard]] Eigen::Matrix2d jacobian(const Vector2d& y) const {
    const double pull = 1 - y.squaredNorm();
    return Eigen::Matrix2d{{pull - 2 * y[0] * y[0], -2 * y[0] * y[1] - 1},
                           {-2 * y[0] * y[1] + 1, pull - 2 * y[1] * y[1]}};
  }
};

void circle(const char* name, const auto& scheme) {
  pinned::run(std::string("circle, ") + name, [&](pinned::Hash& hash) {
    Vector2d y{0.125, 0.25};
    PhiStepper stepper{y, Circle{}, scheme};
    if constexpr (decltype(stepper)::facts.traces) {
      pinned::good(integrate(stepper, y, {0, 10}, tolerance{.rtol = 1e-5, .atol = 1e-6}));
    } else {
      pinned::good(integrate(stepper, y, {0, 10}, fixed(0.015625)));
    }
    hash.add(y);
  });
}

const bool added = pinned::added([] {
  circle("forward_euler", forward_euler);
  circle("trapezoidal", trapezoidal);
  circle("midpoint", midpoint);
  circle("backward_euler", backward_euler);
  circle("phi(0.7)", phi(0.7));
  circle("phi_stage(0.6)", phi_stage(0.6));
  circle("tsit5", tsit5);
  circle("dop853", dop853);
});

}  // namespace
