// Radau IIA under control of its error: tolerance, order, dense output, restarts.
#include <phistep/phistep.hpp>
#include <phistep/schemes/radau/radau.hpp>

#include <cmath>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "problems/hires.hpp"
#include "problems/kepler.hpp"
#include "problems/oregonator.hpp"
#include "problems/robertson.hpp"
#include "problems/van_der_pol.hpp"
#include "support/catch.hpp"
#if PHISTEP_FULL
#include "problems/e5.hpp"
#endif
#if PHISTEP_STRESS
#include <phistep/io/checkpoint.hpp>
#endif

using namespace phistep;

namespace radau_run_cases {

/// Slope of log error over log rtol, by least squares.
struct Regression {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  void add(double a, double b) { n += 1, x += a, y += b, xx += a * a, xy += a * b; }
  [[nodiscard]] double slope() const { return (n * xy - x * y) / (n * xx - x * x); }
};

/// @param kappa  how the problem amplifies errors of size rtol on the way (tests/problems/ten.hpp has it by perturbation)
/// @param a      atol = a rtol
template <class Problem, class Error>
void check_law(const char* name, Problem problem, double a, double kappa, Radau scheme, Error error) {
  Regression regression;
  // Errors scatter by factors of ten from tolerance to tolerance: many of them, so that the slope is one.
  for (double digits = 2; digits <= 12; digits += 0.125) {
    const double rtol = std::pow(10.0, -digits);
    auto y = Problem::start();
    PhiStepper stepper{y, problem, scheme};
    const RunReport report = integrate(stepper, y, {0, Problem::end}, tolerance{.rtol = rtol, .atol = a * rtol});
    CAPTURE(name, scheme.stages, rtol, report.message());
    REQUIRE(report);
    const double off = error(y);
    CHECK(off <= 10 * kappa * rtol);
    // Below, rounding has a part: u times the condition of T (650 for 7 stages) times κ is 7e-12 for HIRES.
    if (digits <= 10) regression.add(std::log(rtol), std::log(std::max(off, 1e-16)));
  }
  CAPTURE(name, scheme.stages);
  CHECK(regression.slope() >= 0.8);
  // 1.1 but for tolerances below 5e-7, where the estimate is held to 16 times them: what isn't stiff then goes as rtol^{13/8}.
  CHECK(regression.slope() <= 1.15);
}

inline double worst(const auto& y, const auto& exact, double a) {
  return ((y - exact).array().abs() / (exact.array().abs() + a)).maxCoeff();
}

}  // namespace radau_run_cases

using namespace radau_run_cases;

#if PHISTEP_FULL

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

#elif PHISTEP_STRESS
// Radau IIA under control of its error, on more problems.

TEST_CASE("the error goes as rtol, from 1e-2 to 1e-12") {
  using problems::Hires, problems::Oregonator, problems::Robertson, problems::VanDerPol;
  // κ by problems::conditioning: 1.4, 92, 6.8, 1.6.
  check_law("Robertson", Robertson{}, 1e-6, 1.4, radau,
            [](const auto& y) { return worst(y, Robertson::exact(), 1e-6); });
  check_law("HIRES", Hires{}, 1e-4, 92, radau, [](const auto& y) { return worst(y, Hires::exact(), 1e-4); });
  check_law("Oregonator", Oregonator{}, 1e-6, 6.8, radau,
            [](const auto& y) { return worst(y, Oregonator::exact(), 1e-6); });
  check_law("Van der Pol", VanDerPol{}, 1, 1.6, radau, [](const auto& y) {
    return std::max(worst(y.r, VanDerPol::exact().r, 1), worst(y.v, VanDerPol::exact().v, 1));
  });
}

TEST_CASE("a run taken up from a checkpoint goes on to the same bits") {
  struct Whole {
    problems::Hires::State y = problems::Hires::start();
    PhiStepper<problems::Hires::State, problems::Hires, Radau> stepper{y, problems::Hires{}, radau};
    Run<decltype(stepper), problems::Hires::State, tolerance> run{
        stepper, y, {0, problems::Hires::end}, tolerance{.rtol = 1e-8, .atol = 1e-12}};
  };
  Whole unbroken;
  std::vector<std::string> places;
  do {
    std::ostringstream out;
    save_checkpoint(out, unbroken.run);
    places.push_back(out.str());
  } while (unbroken.run.advance());
  REQUIRE(unbroken.run.report());
  for (std::size_t k = 0; k < places.size(); k += 3) {
    Whole again;
    std::istringstream in(places[k]);
    load_checkpoint(in, again.run);
    while (again.run.advance()) {  // a save begins the checks of the Jacobian anew, so it is part of the story
      std::ostringstream out;
      save_checkpoint(out, again.run);
    }
    CAPTURE(k);
    CHECK(again.y == unbroken.y);
    CHECK(again.stepper.statistics() == unbroken.stepper.statistics());
  }
}

TEST_CASE("differences in place of a Jacobian, float, and where double precision ends") {
  problems::Robertson problem;
  const auto no_jacobian = [&](const Eigen::Vector3d& y) -> Eigen::Vector3d { return problem(y); };
  Eigen::Vector3d y = problems::Robertson::start();
  PhiStepper stepper{y, no_jacobian, radau};
  REQUIRE(integrate(stepper, y, {0, 40}, tolerance{.rtol = 1e-9, .atol = 1e-15}));
  CHECK(worst(y, problems::Robertson::exact(), 1e-6) <= 1e-8);

  const auto in_float = [](const Eigen::Vector3f& x) -> Eigen::Vector3f {
    const float a = 0.04f * x[0], b = 1e4f * x[1] * x[2], c = 3e7f * x[1] * x[1];
    return {-a + b, a - b - c, c};
  };
  Eigen::Vector3f x{1, 0, 0};
  PhiStepper narrow{x, in_float, radau};
  REQUIRE(integrate(narrow, x, {0, 40}, tolerance{.rtol = 1e-4, .atol = 1e-9}));
  CHECK(worst(x.cast<double>(), problems::Robertson::exact(), 1e-5) <= 1e-3);

  Eigen::Vector3d z = problems::Robertson::start();
  PhiStepper beyond{z, problem, radau};
  CHECK(integrate(beyond, z, {0, 40}, tolerance{.rtol = 1e-16, .atol = 1e-22}).outcome == Outcome::invalid_tolerance);
}

TEST_CASE("a force that is nowhere finite ends the run, and the state is kept") {
  using V = Eigen::Matrix<double, 1, 1>;
  const auto wall = [](const V& y) { return V{y[0] > 0.5 ? std::sqrt(-1.0) : 1.0}; };
  V y{0};
  PhiStepper stepper{y, wall, radau};
  const RunReport report = integrate(stepper, y, {0, 1}, tolerance{.rtol = 1e-6, .atol = 1e-6});
  CHECK_FALSE(report);
  CHECK(y[0] <= 0.5);
  CHECK(y[0] >= 0.4);  // as far as there is a force
}

#endif
