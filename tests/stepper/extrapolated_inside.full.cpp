// What an extrapolated step tells of the solution between its ends, first order; the quick half is extrapolated_inside.test.cpp.
#include "problems/hires.hpp"
#include "stepper/extrapolated_inside_cases.hpp"

TEST_CASE("inside of steps the solution is known to the tolerance, and at their ends as it is") {
  problems::for_each_of_ten([](const auto& problem) {
    if constexpr (!std::remove_cvref_t<decltype(problem)>::is_motion) extrapolated_inside_cases::check_problem(problem);
  });
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
