#pragma once

// A run looked at inside of its steps, for the halves of stepper/extrapolated_inside.
#include <phistep/phistep.hpp>
#include <phistep/stepper/extrapolated.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "problems/kepler.hpp"
#include "problems/ten.hpp"
#include "support/catch.hpp"

using namespace phistep;

namespace extrapolated_inside_cases {

// The table's last entries are held to ten tolerances inside a step; 60 is the worst found on these.
void check_problem(const auto& problem) {
  using Force = std::remove_cvref_t<decltype(problem.force)>;
  REQUIRE(problem.stiff == problems::is_stiff<Force>);
  if constexpr (!problems::is_stiff<Force>) {  // where stiff components spoil the differences, fewer digits
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
  }
}

}  // namespace extrapolated_inside_cases
