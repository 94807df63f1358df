#pragma once

// A tolerance and what a run then errs by, for the halves of schemes/extrapolation/extrapolated_row.
#include <phistep/phistep.hpp>
#include <phistep/schemes/extrapolation/extrapolated.hpp>

#include <cmath>
#include <string>
#include <type_traits>

#include "problems/ten.hpp"
#include "support/catch.hpp"

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"  // of two kinds, which leave in 0.3

using namespace phistep;

namespace extrapolated_row_cases {

class Regression {
 public:
  void add(double x, double y) { n_ += 1, x_ += x, y_ += y, xx_ += x * x, xy_ += x * y; }
  [[nodiscard]] double slope() const { return (n_ * xy_ - x_ * y_) / (n_ * xx_ - x_ * x_); }

 private:
  double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0;
};

// Of κ·rtol, the worst found is 4; slopes 0.93 … 1.08 but for the heat equation's, 1.13: there the last modes die within
// the first steps, which a tighter tolerance resolves better than it has to, and only the upper bound on the error counts.
void check_problem(const auto& problem) {
  using Force = std::remove_cvref_t<decltype(problem.force)>;
  const std::string name = problem.name;
  const double kappa = problems::conditioning(problem);
  const auto check = [&](const char* base, auto scheme) {
    Regression regression;
    for (int digits = 2; digits <= 12; ++digits) {
      const double rtol = std::pow(10.0, -digits);
      auto y = problem.start;
      PhiStepper stepper{y, problem.force, scheme};
      const auto report = integrate(stepper, y, {0, problem.end}, tolerance{.rtol = rtol, .atol = rtol * problem.a});
      CAPTURE(name, base, rtol, kappa, report.message());
      REQUIRE(report);
      const double error = problems::relative_error(y, problem);
      CHECK(error <= 10 * kappa * rtol);
      regression.add(std::log(rtol), std::log(error));
    }
    CAPTURE(name, base, regression.slope());
    CHECK(regression.slope() >= 0.8);
    if (name != "heat, 20 points") CHECK(regression.slope() <= 1.1);
  };
  check("implicit", extrapolated(backward_euler));
  REQUIRE(problem.stiff == problems::is_stiff<Force>);
  if constexpr (!problems::is_stiff<Force>) check("Gragg", extrapolated(forward_euler));
  if constexpr (std::is_same_v<Force, problems::Kepler>) check("Verlet", extrapolated(velocity_verlet));
}

}  // namespace extrapolated_row_cases
