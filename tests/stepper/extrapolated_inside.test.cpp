// What an extrapolated step tells of the solution between its ends.
#include <phistep/phistep.hpp>
#include <phistep/stepper/extrapolated.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "problems/hires.hpp"
#include "problems/kepler.hpp"
#include "problems/ten.hpp"
#include "support/catch.hpp"

using namespace phistep;

// The table's last entries are held to ten tolerances inside a step; 60 is the worst found on these.
TEST_CASE("inside of steps the solution is known to the tolerance, and at their ends as it is") {
  problems::for_each_of_ten([](const auto& problem) {
    if (problem.stiff) return;  // where stiff components spoil the differences, fewer digits
    std::vector<double> times;
    for (int i = 1; i < 60; ++i) times.push_back(problem.end * i / 60);
    const auto look = [&](double rtol, auto seen) {
      std::vector<problems::Vector> at;
      auto y = problem.start;
      PhiStepper stepper{y, problem.force, extrapolated(backward_euler)};
      REQUIRE(integrate(stepper, y, {0, problem.end}, tolerance{.rtol = rtol, .atol = rtol * problem.a},
                        seen(times, [&](double, const auto& x) { at.push_back(problems::stacked(x)); })));
      return at;
    };
    const auto inside = look(1e-6, [](auto& t, auto f) { return sampled(t, f); });
    const auto exact = look(1e-11, [](auto& t, auto f) { return at_times(t, f); });
    REQUIRE(inside.size() == exact.size());
    double worst = 0;
    for (std::size_t i = 0; i < exact.size(); ++i)
      worst = std::max(worst, problems::relative_error(inside[i], exact[i], problem.a));
    CAPTURE(problem.name, worst);
    CHECK(worst <= 1e-4);
  });
}

TEST_CASE("an event cuts a step where it happens, to the accuracy of the run") {
  const problems::Kepler kepler;
  for (const double rtol : {1e-5, 1e-9}) {
    auto y = kepler.start();
    PhiStepper stepper{y, kepler, extrapolated(backward_euler)};
    double when = 0;
    // r_x = −e − … : the apocentre side is crossed at a quarter of the eccentric anomaly E = π/2.
    const auto report = integrate(stepper, y, {0, 3}, tolerance{.rtol = rtol, .atol = rtol},
                                  event([](double, const auto& x) { return x.r[0] + 0.6; }, {},
                                        [&](double t, auto&) { return when = t, false; }));
    CHECK(report.outcome == Outcome::stopped_by_event);
    // Kepler's equation: t = π/2 − e.
    CHECK(std::abs(when - (1.5707963267948966 - 0.6)) <= 100 * rtol);
  }
}

TEST_CASE("to look inside takes a few times the steps at most, and near rounding no more of them") {
  for (const double rtol : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    const auto steps = [rtol](auto&&... observer) {
      auto y = problems::Hires::start();
      PhiStepper stepper{y, problems::Hires{}, extrapolated(backward_euler)};
      const auto report =
          integrate(stepper, y, {0.0, problems::Hires::end}, tolerance{.rtol = rtol, .atol = 1e-4 * rtol}, observer...);
      REQUIRE(report);
      return report.statistics.steps;
    };
    const auto watched = steps(sampled(1.0, [](double, const auto&) {})), alone = steps();
    CAPTURE(rtol, watched, alone);
    CHECK(watched <= (rtol < 1e-9 ? alone : 4 * alone));
  }
}
