// Small runs whose work is counted: what a step costs beside its force.
#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include "pinned/pinned.hpp"
#include "problems/kepler_force.hpp"
#include "problems/robertson.hpp"

namespace {

using namespace phistep;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// The planar pendulum's flow without its sine: y" = −y + y³/6.
Vector2d swing(const Vector2d& y) { return {y[1], y[0] * (y[0] * y[0] / 6 - 1)}; }

/// A chain of n masses that pull at their neighbours, linear and cubic: not stiff, any n.
VectorXd chain(const VectorXd& y) {
  const Eigen::Index n = y.size() / 2;
  VectorXd rate(2 * n);
  rate.head(n) = y.tail(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double left = y[i] - (i > 0 ? y[i - 1] : 0), right = (i + 1 < n ? y[i + 1] : 0) - y[i];
    rate[n + i] = right - left + 0.125 * (right * right * right - left * left * left);
  }
  return rate;
}

void flow(const char* name, auto y, auto force, const auto& scheme, double t1, const auto& control) {
  pinned::run(name, [&](pinned::Hash& hash) {
    PhiStepper stepper{y, force, scheme};
    pinned::good(integrate(stepper, y, {0, t1}, control));
    hash.add(y);
  });
}

const bool added = pinned::added([] {
  flow("swing by the trapezoidal rule, 5,000 steps", Vector2d{1, 0}, swing, trapezoidal, 78.125, fixed(0.015625));
  flow("swing by dop853", Vector2d{1, 0}, swing, dop853, 500, tolerance{.rtol = 1e-9, .atol = 1e-9});
  VectorXd y = VectorXd::Zero(40);
  y[3] = 1, y[31] = -0.5;
  flow("chain of 40 numbers, VectorXd, by tsit5", y, chain, tsit5, 100, tolerance{.rtol = 1e-6, .atol = 1e-6});
  flow("planet by Verlet, 20,000 steps", Motion<Vector2d>{Vector2d{0.5, 0}, Vector2d{0, 1.75}}, problems::KeplerForce{},
       velocity_verlet, 78.125, fixed(0.00390625));
  flow("Robertson by rodas4p2 to 1e-8", problems::Robertson::start(), problems::Robertson{}, rodas4p2,
       problems::Robertson::end, tolerance{.rtol = 1e-8, .atol = 1e-12});
});

}  // namespace
