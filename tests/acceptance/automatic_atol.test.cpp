// Without an atol of the user's: components of one vector whose sizes differ by decades, and components that are nothing but
// the errors of others.
#include <phistep/phistep.hpp>
#include <phistep/schemes/radau/radau.hpp>

#include <cmath>

#include "problems/hires.hpp"
#include "problems/relaxation.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;

namespace {

struct Outcomes {
  double error;
  std::int64_t tries;
};
/// @param size  the largest magnitudes of the components, relative to which errors are measured
template <class State>
Outcomes run(const shared_force::OfState<State>& force, auto scheme, State y, double end, const State& exact,
             const State& size, double rtol) {
  PhiStepper stepper{y, force, scheme};
  const RunReport report = integrate(stepper, y, {0, end}, tolerance{.rtol = rtol, .max_steps = 100'000});
  CAPTURE(report.message());
  REQUIRE(report);
  return {((y - exact).array() / size.array()).abs().maxCoeff(),
          report.statistics.steps + report.statistics.rejections};
}

/// The relaxation oscillation with μ = 1000: y = (x, x'), x = 2 … −2, x' up to 1300 in the jumps.
struct Slow {
  using State = Eigen::Vector2d;
  State operator()(const State& y) const { return {y[1], 1e3 * (1 - y[0] * y[0]) * y[1] - y[0]}; }
};
/// y₃' = −1000 (y₃ − (y₁² + y₂² − 1)) on a circle: 0 but for the errors of y₁ and y₂.
struct Difference {
  using State = Eigen::Vector3d;
  State operator()(const State& y) const { return {-y[1], y[0], -1e3 * (y[2] - (y[0] * y[0] + y[1] * y[1] - 1))}; }
};

template <class State>
void check_wide(const char* name, const shared_force::OfState<State>& force, const State& start, double end,
                const State& exact, const State& size, double kappa) {
  for (const double rtol : {1e-3, 1e-4, 1e-6}) {
    CAPTURE(name, rtol);
    CHECK(run<State>(force, rodas4, start, end, exact, size, rtol).error < 10 * kappa * rtol);
    CHECK(run<State>(force, rodas5p, start, end, exact, size, rtol).error < 10 * kappa * rtol);
    CHECK(run<State>(force, radau, start, end, exact, size, rtol).error < 10 * kappa * rtol);
  }
}

}  // namespace

TEST_CASE("van der Pol: x = 2 beside x' = 1e3 and 1e6 in one vector, no atol given") {
  // x(2000) by Radau IIA at rtol 1e-14 and the slow branch's x' = x/(μ(1 − x²)).
  const Eigen::Vector2d slow(1.706167732170469, -8.928097010248125e-4);
  check_wide<Eigen::Vector2d>("mu = 1e3", Slow{}, {2, 0}, 2000, slow, {2, 1300}, 2.3);
  using P = problems::Relaxation;
  check_wide<Eigen::Vector2d>("mu = 1e6", P{}, P::start(), P::end, P::exact(), {2, 1.3e6}, 2.3);
}

TEST_CASE("HIRES: seven components of 1e-2 to 1 beside one that starts at 0.0057, no atol given") {
  using P = problems::Hires;
  P::State size;
  size << 1, 0.15, 0.02, 0.4, 0.03, 0.25, 0.0057, 0.0057;
  const P::State start = P::start(), exact = P::exact();
  for (const double rtol : {1e-4, 1e-6}) {
    CHECK(run<P::State>(P{}, rodas4, start, P::end, exact, size, rtol).error < 10 * rtol);
    CHECK(run<P::State>(P{}, rodas5p, start, P::end, exact, size, rtol).error < 10 * rtol);
  }
}

TEST_CASE(
    "a component made of the errors of others forces no tiny steps: less than five times those of an atol given") {
  const Eigen::Vector3d start(1, 0, 0), exact(std::cos(20.0), std::sin(20.0), 0), size(1, 1, 1);
  for (const double rtol : {1e-4, 1e-6}) {
    Eigen::Vector3d y = start;
    const shared_force::OfState<Eigen::Vector3d> difference = Difference{};
    PhiStepper stepper{y, difference, rodas5p};
    const RunReport given = integrate(stepper, y, {0, 20}, tolerance{.rtol = rtol, .atol = rtol});
    REQUIRE(given);
    const Outcomes got = run<Eigen::Vector3d>(difference, rodas5p, start, 20, exact, size, rtol);
    CHECK(got.error < 10 * rtol);
    CHECK(got.tries < 5 * given.statistics.steps);
  }
}

TEST_CASE("automatic atol: a pulse that grows out of zero through subnormal numbers") {
  using One = Eigen::Vector<double, 1>;
  // y' = exp(−50 (t − 5)²), y(0) = 0: y(10) = √(π/50), and less than 1e-308 until t = 1.2
  const auto run = [](auto zero, const auto& scheme) {
    using Y = decltype(zero);
    const shared_force::OfStateAndTime<Y> pulse = [](const Y&, double t) -> Y {
      return Y::Constant(1, 1, std::exp(-50 * (t - 5) * (t - 5)));
    };
    Y y = zero;
    PhiStepper stepper{y, pulse, scheme};
    const RunReport report =
        integrate(stepper, y, {0, 10}, tolerance{.rtol = 1e-4, .max_step = 0.1, .max_steps = 20000});
    CAPTURE(report.message());
    CHECK(report);
    CHECK(y[0] == Approx(std::sqrt(std::acos(-1.0) / 50)).epsilon(1e-3));
  };
  run(One::Zero().eval(), dop853);
  run(Eigen::VectorXd::Zero(1).eval(), tsit5);
  run(Eigen::VectorXd::Zero(1).eval(), rodas5p);
}
