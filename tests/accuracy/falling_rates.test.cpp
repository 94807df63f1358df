// A rate that falls: the error that a large L has hidden is carried on, and the estimate must have seen it.
#include "accuracy/falling_rates_cases.hpp"
#include "support/catch.hpp"

// Beside each number a few more are let pass: rounding decides some members.
#if PHISTEP_STRESS
constexpr int members = 400, known_unknown = 4, known_samples = 24;
#elif PHISTEP_FULL
constexpr int members = 100, known_unknown = 1, known_samples = 10;
#endif

using falling_rates::Answers;

namespace {

const Answers& answers() {
  static const Answers all = [] {
    Answers of{"falling rates"};
    falling_rates::ask(of, members, "radau", falling_rates::by(phistep::radau));
    falling_rates::ask(of, members, "rodas5p", falling_rates::by(phistep::rodas5p));
    falling_rates::ask(of, members, "rodas4p2", falling_rates::by(phistep::rodas4p2));
    falling_rates::ask(of, members, "tr_bdf2", falling_rates::by(phistep::tr_bdf2));
    return of;
  }();
  return all;
}

}  // namespace

TEST_CASE("falling rates: hardly any is wrong") {
  falling_rates::tell_calls(answers());
  battery::at_most(known_unknown, answers().unknown);
}
TEST_CASE("falling rates: none is wrong where steps end on the jumps") { battery::at_most(0, answers().known); }
// Where the run without samples succeeds.
TEST_CASE("falling rates: samples make no run fail") { battery::at_most(0, answers().sampled_runs); }

// Where the ends of all steps are right.
TEST_CASE("falling rates, samples: no more are wrong than known") {
  battery::at_most(known_samples, answers().samples);
}
TEST_CASE("falling rates, samples: none is wrong", "[!shouldfail][48]") { battery::none(answers().samples); }
