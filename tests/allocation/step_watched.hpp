#pragma once

// Steps that are watched, rejected or doubled, and whole controlled runs between their first steps.

#include "allocation/step_cases.hpp"

namespace {

using Attempt = std::function<StepReport(int n)>;
[[maybe_unused]] void check_attempts(const Attempt& attempt) {
  std::int64_t total = 0;
  for (int n = 0; n < 12; ++n) {
    heap::count = 0;
    heap::counting = n > 1;
    const StepReport step = attempt(n);
    heap::counting = false;
    total += heap::count;
    CAPTURE(under_test);
    REQUIRE((step || step.outcome() == Outcome::error_too_large));
  }
  CAPTURE(under_test);
  CHECK(total == 0);
}
template <class S>
void check_none_watched(S state, auto force, auto scheme, const auto&... more) {
  PhiStepper stepper{state, force, scheme, more...};
  StepDoubling<decltype(stepper), S> doubling;
  doubling.resize(state);
  Trace<S> trace;
  trace.resize(state);
  check_attempts([&](int n) {
    const auto judge = [n](const auto&...) { return n % 3 != 2; };
    StepReport step;
    bool direct = false;
    if constexpr (facts_of<std::remove_cvref_t<decltype(stepper)>>.traces) {
      direct = stepper.estimates(trace);
      if (direct) step = stepper.attempt(state, 0.1 * n, 0.02 + 0.001 * n, Origin::unknown, trace, judge);
    }
    if (!direct) step = doubling.attempt(stepper, state, 0.1 * n, 0.02 + 0.001 * n, Origin::unknown, trace, judge);
    if (step) trace.advance();
    return step;
  });
}

[[maybe_unused]] void check_run(const std::function<bool()>& advance, const std::function<RunReport()>& report) {
  for (int n = 0; n < 3; ++n) REQUIRE(advance());
  heap::count = 0;
  heap::counting = true;
  while (advance()) {
  }
  heap::counting = false;
  CHECK(heap::count == 0);
  CHECK(report());
  CHECK(report().statistics.steps > 10);
}
template <class S>
void check_none_run(S state, auto force, auto scheme, const auto& control) {
  PhiStepper stepper{state, force, scheme};
  Run run{stepper, state, {0.0, 2.0}, control};
  check_run([&run] { return run.advance(); }, [&run] { return run.report(); });
}
/// Looks into every step: the first come from a step done there, those after the second from parts of the step.
template <class S>
void check_none_sampled(S state, auto force, auto scheme, const auto& control, double every) {
  PhiStepper stepper{state, force, scheme};
  std::int64_t looks = 0;
  Run run{stepper, state, {0.0, 2.0}, control, sampled(every, [&looks](double, const S&) { ++looks; })};
  for (int n = 0; n < 9; ++n) REQUIRE(run.advance());
  check_run([&run] { return run.advance(); }, [&run] { return run.report(); });
  CAPTURE(looks);
  CHECK(looks > 4 * run.report().statistics.steps);
}

}  // namespace
