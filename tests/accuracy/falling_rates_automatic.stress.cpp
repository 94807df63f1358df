// A rate that falls, by integrate without a stepper.
#include <phistep/automatic.hpp>

#include "accuracy/falling_rates_cases.hpp"
#include "support/catch.hpp"

// Beside each number a few more are let pass: rounding decides some members.
constexpr int members = 600, known_unknown = 306, known_known = 161, known_samples = 15, known_sampled_runs = 56;

using falling_rates::Answers;

namespace {

const Answers& answers() {
  static const Answers all = [] {
    Answers of{"falling rates, automatic"};
    falling_rates::ask(of, members, "automatic",
                       [](Eigen::VectorXd& y, auto force, auto span, const auto& control, auto&&... observers) {
                         return phistep::RunReport(phistep::integrate(y, force, span, control, observers...));
                       });
    return of;
  }();
  return all;
}

}  // namespace

TEST_CASE("falling rates, automatic: no more are wrong than known") {
  falling_rates::tell_calls(answers());
  battery::at_most(known_unknown, answers().unknown);
}
TEST_CASE("falling rates, automatic: none is wrong", "[!shouldfail][48]") { battery::none(answers().unknown); }

TEST_CASE("falling rates, automatic, steps end on the jumps: no more are wrong than known") {
  battery::at_most(known_known, answers().known);
}
TEST_CASE("falling rates, automatic, steps end on the jumps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers().known);
}

// Where the ends of all steps are right.
TEST_CASE("falling rates, automatic, samples: no more are wrong than known") {
  battery::at_most(known_samples, answers().samples);
}
TEST_CASE("falling rates, automatic, samples: none is wrong", "[!shouldfail][48]") { battery::none(answers().samples); }

// Where the run without samples succeeds.
TEST_CASE("falling rates, automatic, runs with samples: no more fail than known") {
  battery::at_most(known_sampled_runs, answers().sampled_runs);
}
TEST_CASE("falling rates, automatic, runs with samples: none fails", "[!shouldfail][48]") {
  battery::none(answers().sampled_runs);
}
