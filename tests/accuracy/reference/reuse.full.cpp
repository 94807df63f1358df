// In short: accuracy/reference/stiff.test.cpp.
// How often a stiff run makes a Jacobian, a factorization and an iteration, beside CVODE on the same steps.

#include <phistep/phistep.hpp>

#include "accuracy/reference/cvode.hpp"
#include "problems/hires.hpp"
#include "problems/robertson.hpp"
#include "support/catch.hpp"

using Vec = Eigen::VectorXd;

namespace {

/// Backward Euler over the steps that CVODE chose.
template <class Problem>
phistep::Statistics follow(const Problem& problem, const Vec& start, const reference::Run& run, double rtol,
                           double atol) {
  Vec y = start;
  phistep::PhiStepper stepper{y, problem, phistep::backward_euler, phistep::newton({.rtol = rtol, .atol = atol})};
  for (std::size_t n = 1; n < run.times.size(); ++n) {
    const auto report = stepper.step(y, run.times[n - 1], run.times[n] - run.times[n - 1]);
    CAPTURE(n, report.message());
    REQUIRE(report);
  }
  return stepper.statistics();
}

/// Found, at rtol 1e-3, 1e-5, 1e-7 (CVODE's in brackets):
///   HIRES      226, 356, 671 steps: Jacobians 39 (8), 65 (10), 151 (14); factorizations 68 (57), 116 (78), 225 (120);
///              iterations 621 (389), 1248 (552), 2784 (963)
///   Robertson  253, 372, 876 steps: Jacobians 36 (6), 41 (7), 52 (16); factorizations 76 (53), 95 (62), 164 (144);
///              iterations 567 (369), 1182 (526), 3227 (1203)
/// Bounds are shares of the steps, or multiples of CVODE's count: those found, rounded up.
struct Bounds {
  double jacobians, factorizations, iterations;
};

template <class Problem>
void compare(const Problem& problem, const Vec& start, double end, double rtol, double atol, Bounds bounds) {
  const auto f = [&](double, const reference::Vector& y) -> reference::Vector { return problem(y); };
  const auto run = reference::cvode_run(f, start, end, rtol, Vec::Constant(start.size(), atol), {.every_step = true});
  const auto ours = follow(problem, start, run, rtol, atol);
  const auto steps = static_cast<double>(run.times.size() - 1);
  CAPTURE(rtol, steps, ours.jacobians, run.jacobians, ours.factorizations, run.factorizations, ours.iterations,
          run.iterations);
  CHECK(static_cast<double>(ours.jacobians) <= bounds.jacobians * steps);
  CHECK(static_cast<double>(ours.factorizations) <= bounds.factorizations * static_cast<double>(run.factorizations));
  CHECK(static_cast<double>(ours.iterations) <= bounds.iterations * static_cast<double>(run.iterations));
  // CVODE renews a Jacobian after 51 steps at the latest and predicts with its own high order; who starts from y needs
  // more iterations and newer Jacobians. It never needs one a step.
  CHECK(ours.jacobians >= run.jacobians);
}

}  // namespace

TEST_CASE("HIRES: Jacobians and factorizations serve several steps, at changing steps too") {
  using problems::Hires;
  compare(Hires{}, Hires::start(), Hires::end, 1e-3, 1e-3 * 1e-4, {0.25, 2, 3});
  compare(Hires{}, Hires::start(), Hires::end, 1e-5, 1e-5 * 1e-4, {0.25, 2, 3});
  compare(Hires{}, Hires::start(), Hires::end, 1e-7, 1e-7 * 1e-4, {0.25, 2, 3});
}

TEST_CASE("Robertson: Jacobians and factorizations serve several steps, at changing steps too") {
  using problems::Robertson;
  compare(Robertson{}, Robertson::start(), 1e4, 1e-3, 1e-3 * 1e-6, {0.25, 2, 3});
  compare(Robertson{}, Robertson::start(), 1e4, 1e-5, 1e-5 * 1e-6, {0.25, 2, 3});
  compare(Robertson{}, Robertson::start(), 1e4, 1e-7, 1e-7 * 1e-6, {0.25, 2, 3});
}
