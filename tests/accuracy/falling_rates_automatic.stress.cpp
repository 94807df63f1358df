// A rate that falls, by integrate without a stepper.
#include <phistep/automatic.hpp>

#include "accuracy/falling_rates_cases.hpp"
#include "support/catch.hpp"

// Beside each number a few more are let pass: rounding decides some members.
constexpr int members = 600, known_unknown = 5, known_samples = 22;

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
TEST_CASE("falling rates, automatic: none is wrong where steps end on the jumps") {
  battery::at_most(0, answers().known);
}
// Where the run without samples succeeds.
TEST_CASE("falling rates, automatic: samples make no run fail") { battery::at_most(0, answers().sampled_runs); }

// Where the ends of all steps are right.
TEST_CASE("falling rates, automatic, samples: no more are wrong than known") {
  battery::at_most(known_samples, answers().samples);
}
TEST_CASE("falling rates, automatic, samples: none is wrong", "[!shouldfail][48]") { battery::none(answers().samples); }
