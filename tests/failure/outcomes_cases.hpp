// What outcomes.test.cpp and outcomes.full.cpp share.
#pragma once

#include <phistep/phistep.hpp>

#include <cmath>

#include "contract/states.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;
using states::same_bits;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using One = Eigen::Matrix<double, 1, 1>;

namespace outcomes_cases {

/// y' = J y, with a Jacobian of the test's choice.
struct Linear {
  Mat J, claimed;
  Vec operator()(const Vec& y) const { return J * y; }
  Mat jacobian(const Vec&) const { return claimed; }
};
using ByDifferences = shared_force::OfState<Vec>;

/// What is said of a failed step, and that y and the statistics know of it.
inline void check_failed(Outcome expected, const StepReport& report, const Vec& y, const Vec& before,
                         const Statistics& statistics) {
  INFO(report.message());
  CHECK(report.outcome() == expected);
  CHECK(report.failure().outcome == expected);
  CHECK_THAT(report.message(), contains(describe(expected)) && contains(advise(expected)) && contains("dt = 1"));
  CHECK(same_bits(y, before));
  CHECK(statistics.failed_steps == 1);
  CHECK(statistics.steps == 0);
}
/// One step of dt = 1 that must fail so, in message and report alike, and leave y.
template <class F, class... More>
void must_fail(Outcome expected, Vec y, F force, auto scheme, const More&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  const Vec before = y;
  const StepReport report = stepper.step(y, 0, 1);
  check_failed(expected, report, y, before, stepper.statistics());
}

inline Mat identity(int n) { return Mat::Identity(n, n); }

}  // namespace outcomes_cases
