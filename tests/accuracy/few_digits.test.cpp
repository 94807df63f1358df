// Few digits over hundreds of time units: weakly nonlinear equations with periodic forcing, at steps of which some skip
// whole periods, in one dimension, where errors meet nothing else.
#include <phistep/automatic.hpp>
#include <phistep/phistep.hpp>

#include <cmath>

#include "support/catch.hpp"

using namespace phistep;

namespace {

using One = Eigen::Matrix<double, 1, 1>;
constexpr double rtol = 1e-3, end = 300;  // [time]

/// The end of each run of the family, in units of rtol max(|y|, 1); κ = 1: a perturbation fades.
/// @param run  y, force, control
void check_all(auto&& run) {
  const auto look = [&](double start, const auto& f) {
    const auto force = [&f](const One& y, double t) -> One { return One{f(y[0], t)}; };
    One truth{start}, y{start};
    PhiStepper fine{truth, force, dop853};
    REQUIRE(integrate(fine, truth, {0, end}, tolerance{.rtol = 1e-11, .atol = 1e-12}));
    REQUIRE(run(y, force, tolerance{.rtol = rtol, .atol = rtol}));
    const double off = std::abs(y[0] - truth[0]) / (rtol * std::max(std::abs(truth[0]), 1.0));
    CAPTURE(start, truth[0], off);
    CHECK(off < 100);
  };
  for (const double w : {0.3, 1.0, 3.0, 6.2832, 20.0})
    for (const double a : {0.01, 0.1, 0.5, 1.0}) {
      CAPTURE(w, a);
      look(0.3, [=](double y, double t) { return a * y * (1 + 0.8 * std::sin(w * t) - y); });  // seasons
      look(0.5, [=](double y, double t) { return -a * y * y * y + std::cos(w * t); });
      look(0.5, [=](double y, double t) { return -a * std::sin(y) + 0.5 * a * std::cos(w * t); });  // a pendulum in oil
      look(0.5, [=](double y, double t) { return -a * y + std::cos(w * t) + std::cos(1.618 * w * t); });
    }
}

}  // namespace

#if PHISTEP_QUICK

TEST_CASE("few digits for long: tsit5 keeps within 100 rtol") {
  check_all([](One& y, const auto& force, const tolerance& control) {
    PhiStepper stepper{y, force, tsit5};
    return integrate(stepper, y, {0, end}, control);
  });
}

TEST_CASE("few digits for long: a run without a stepper keeps within 100 rtol") {
  check_all([](One& y, const auto& force, const tolerance& control) { return integrate(y, force, {0, end}, control); });
}

TEST_CASE("few digits for long: a tolerance of 3e-5 or less is asked as it is") {
  const auto steps = [](double wanted) {
    One y{0.5};
    const auto force = [](const One& x, double t) -> One { return One{std::cos(t) - 0.1 * x[0]}; };
    PhiStepper stepper{y, force, tsit5};
    return static_cast<double>(
        integrate(stepper, y, {0, end}, tolerance{.rtol = wanted, .atol = wanted}).statistics.steps);
  };
  // Δt goes as the fifth root of what is asked, above 3e-5 of its square root.
  const double fine = steps(3e-7) / steps(3e-5), coarse = steps(3e-5) / steps(3e-3);
  CAPTURE(fine, coarse);
  CHECK(fine > 2);
  CHECK(coarse < 2);
}

#endif
