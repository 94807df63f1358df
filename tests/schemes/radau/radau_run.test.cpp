// Radau IIA under control of its error: tolerance, order, dense output, restarts.
#include "problems/e5.hpp"
#include "schemes/radau/radau_run_cases.hpp"

using namespace radau_run_cases;

TEST_CASE("the error goes as rtol, from 1e-2 to 1e-12") {
  using problems::Robertson;
  check_law("Robertson", Robertson{}, 1e-6, 1.4, radau,
            [](const auto& y) { return worst(y, Robertson::exact(), 1e-6); });  // κ by problems::conditioning
}

TEST_CASE("inside a step: the collocation polynomial, of order s") {
  // r' and v' of a motion's interpolant come from the stages: 4 digits more than the ends' Hermite cubic would have.
  const problems::Kepler kepler{0.3};
  auto y = kepler.start();
  PhiStepper stepper{y, kepler, radau(7)};
  double inside = 0;
  std::vector<double> times;
  for (int k = 1; k < 60; ++k) times.push_back(0.1 * k);
  auto at =
      sampled(times, [&](double t, const auto& now) { inside = std::max(inside, (now.r - kepler.exact(t).r).norm()); });
  const RunReport report = integrate(stepper, y, {0, 6}, tolerance{.rtol = 1e-10, .atol = 1e-10}, at);
  INFO(report.message());
  REQUIRE(report);
  CHECK(report.statistics.steps < 40);  // of a sixth of a unit of time and more: far apart for a cubic
  // The polynomial's order is 7 in place of 13: its error is of the size of the estimate, rtol^{8/13}.
  CHECK(inside <= 1e-6);
  CHECK((y.r - kepler.exact(6).r).norm() <= 1e-8);
}

TEST_CASE("differences in place of a Jacobian, float, and where double precision ends") {
  Eigen::Vector3d z = problems::Robertson::start();
  PhiStepper beyond{z, problems::Robertson{}, radau};
  CHECK(integrate(beyond, z, {0, 40}, tolerance{.rtol = 1e-16, .atol = 1e-22}).outcome == Outcome::invalid_tolerance);
}

TEST_CASE("one particle that needs short steps rules Radau's steps in the particle norm") {
  using Columns = Eigen::Matrix2Xd;
  const Index n = 20;
  const auto steps = [&](Norm norm) {
    Motion<Columns> y{Columns::Ones(2, n), Columns::Zero(2, n)};
    PhiStepper stepper{y,
                       [](const Columns& r) -> Columns {
                         Columns f = -r;
                         f.col(7) *= 400;
                         return f;
                       },
                       radau};
    const RunReport report = integrate(stepper, y, {0, 10}, tolerance{.rtol = 1e-5, .norm = norm});
    REQUIRE(report);
    return static_cast<double>(report.statistics.steps);
  };
  CHECK(steps(Norm::particle) > 1.1 * steps(Norm::rms));
}

TEST_CASE("E5 to 1e11: components that fall by ten decades keep what rounding leaves of y2 = y3 + y4") {
  // One rounding of 1.5e-10, where y2 is largest, is 1.9e-6 of what is left at the end.
  using P = problems::E5;
  const P::State exact = P::at_1e11();
  for (const double rtol : {1e-7, 1e-8, 1e-9, 1e-10, 1e-11}) {
    P::State y = P::start();
    PhiStepper stepper{y, P{}, radau};
    CAPTURE(rtol);
    REQUIRE(integrate(stepper, y, {0, 1e11}, tolerance{.rtol = rtol, .atol = 1e-22 * rtol}));
    CHECK((y - exact).cwiseQuotient(exact).segment<2>(1).cwiseAbs().maxCoeff() <= 4 * 1.9e-6);
  }
}
