// Every problem of DETEST, and the other smooth ones, at coarse, medium and tight tolerances: each run is a success, and its
// answer right. The quick half: detest.test.cpp.

#include "acceptance/detest_cases.hpp"

TEST_CASE("smooth problems are solved to their tolerance") {
  for (const SmoothProblem& problem : smooth_problems()) {
    const double kappa = conditioning_of(problem);
    for (const double rtol : {1e-3, 1e-6, 1e-9}) {
      const phistep::tolerance control{.rtol = rtol, .atol = rtol};
      for_each_explicit([&](const char* name, auto scheme) {
        Eigen::VectorXd y = problem.start;
        phistep::PhiStepper stepper{y, problem, scheme};
        const auto report = phistep::integrate(stepper, y, {0, problem.end}, control);
        check_end(problem, name, rtol, kappa, report, y);
      });
      if (problem.acceleration == nullptr) continue;
      const auto half = problem.start.size() / 2;
      for_each_nystrom([&](const char* name, auto scheme) {
        phistep::Motion<Eigen::VectorXd> y{problem.start.head(half), problem.start.tail(half)};
        phistep::PhiStepper stepper{y, problem.force(), scheme};
        const auto report = phistep::integrate(stepper, y, {0, problem.end}, control);
        check_end(problem, name, rtol, kappa, report, problems::stacked(y));
      });
    }
  }
}
