// In short: accuracy/reference/stiff.test.cpp.
// What the tolerances of CVODE and ARKODE mean on the ten problems of tests/accuracy/tolerance.test.cpp, counted alike:
// errors above 10 and above 100 times κ·rtol, and runs that were given up, of 7 on each problem. Printed, not judged; what
// is checked is that both are driven rightly, and agree with the digits that everybody is judged by.

#include <phistep/phistep.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "accuracy/reference/arkode.hpp"
#include "accuracy/reference/cvode.hpp"
#include "problems/show_digits.hpp"
#include "problems/ten.hpp"
#include "support/catch.hpp"

namespace {

using problems::Vector;
using Solver =
    std::function<reference::Run(const reference::RightHandSide&, const Vector&, double, double, const Vector&)>;

struct Count {
  std::string name;
  Solver run;
  bool explicit_method = false;
  int runs = 0, failed = 0, above_10 = 0, above_100 = 0;
  double worst = 0;
};

Count arkode(const std::string& name, reference::ArkodeOptions options) {
  return {name,
          [options](const auto& f, const Vector& y0, double end, double rtol, const Vector& atol) {
            return reference::arkode_run(f, y0, end, rtol, atol, options);
          },
          options.method == reference::RungeKutta::explicit_};
}

}  // namespace

TEST_CASE("what the tolerances of CVODE and ARKODE mean on the same ten problems") {
  std::vector<Count> counts{
      {"CVODE BDF", [](const auto& f, const Vector& y0, double end, double rtol, const Vector& atol) {
         return reference::cvode_run(f, y0, end, rtol, atol);
       }}};
  for (const int order : {2, 3, 4, 5})
    counts.push_back(arkode("ARKODE DIRK" + std::to_string(order), {.order = order}));
  counts.push_back(arkode("ARKODE DIRK4, as it comes", {.order = 4, .as_it_comes = true}));
  counts.push_back(arkode("ARKODE ERK4", {.method = reference::RungeKutta::explicit_, .order = 4}));

  problems::for_each_of_ten([&](const auto& problem) {
    const auto f = problems::right_hand_side(problem);
    const Vector y0 = problems::stacked(problem.start), exact = problems::stacked(problem.exact);
    const double kappa = problems::conditioning(problem);
    for (Count& count : counts) {
      if (count.explicit_method && problem.stiff) continue;
      for (int digits = 2; digits <= 8; ++digits) {
        const double rtol = std::pow(10.0, -digits);
        ++count.runs;
        try {
          const auto run = count.run(f, y0, problem.end, rtol, Vector::Constant(y0.size(), rtol * problem.a));
          const double share = problems::relative_error(run.y, exact, problem.a) / (kappa * rtol);
          count.worst = std::max(count.worst, share);
          count.above_10 += share > 10;
          count.above_100 += share > 100;
        } catch (const std::exception&) {
          ++count.failed;
        }
      }
    }
    // The digits are right: CVODE's own error at rtol = 1e-12 is within 1e3 κ·rtol (found: 240 at most, Brusselator), and
    // the extrapolation that measures κ is as good.
    CAPTURE(problem.name, kappa);
    const auto tight = reference::cvode_run(f, y0, problem.end, 1e-12, Vector::Constant(y0.size(), 1e-12 * problem.a));
    CHECK(problems::relative_error(tight.y, exact, problem.a) <= 1e-9 * kappa);
    CHECK(problems::relative_error(problems::extrapolate(f, y0, 0, problem.end, problem.a, 1e-12), exact, problem.a) <=
          1e-9 * kappa);
  });

  std::printf("errors above 10 and 100 times kappa*rtol, worst, and failures, rtol = 1e-2 ... 1e-8\n");
  for (const Count& count : counts)
    std::printf("  %-28s %2d runs: %2d above 10, %d above 100, worst %.3g, %2d failed\n", count.name.c_str(),
                count.runs, count.above_10, count.above_100, count.worst, count.failed);
}

TEST_CASE("ARKODE's failures are not swallowed") {
  const auto broken = [](double, const Vector&) -> Vector { throw std::logic_error("no"); };
  const Vector one = Vector::Ones(1);
  CHECK_THROWS_AS(reference::arkode_run(broken, one, 1.0, 1e-6, one), std::logic_error);
  const auto decay = [](double, const Vector& y) -> Vector { return -y; };
  CHECK_THROWS_AS(reference::arkode_run(decay, one, 1.0, 1e-6, -one), std::runtime_error);  // a negative tolerance
  // e⁻¹ by each kind.
  for (const auto method : {reference::RungeKutta::diagonally_implicit, reference::RungeKutta::explicit_})
    CHECK(reference::arkode_run(decay, one, 1.0, 1e-8, 1e-8 * one, {.method = method}).y[0] ==
          Approx(std::exp(-1.0)).epsilon(1e-7));
}
