// A rate that falls: the error that a large L has hidden is carried on, and the estimate must have seen it.
#include "accuracy/falling_rates_cases.hpp"
#include "support/catch.hpp"

// Beside each number a few more are let pass: rounding decides some members.
#if PHISTEP_STRESS
constexpr int members = 400, known_unknown = 683, known_known = 444, known_samples = 40, known_sampled_runs = 135;
#elif PHISTEP_FULL
constexpr int members = 100, known_unknown = 179, known_known = 122, known_samples = 15, known_sampled_runs = 35;
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

TEST_CASE("falling rates: no more are wrong than known") {
  falling_rates::tell_calls(answers());
  battery::at_most(known_unknown, answers().unknown);
}
TEST_CASE("falling rates: none is wrong", "[!shouldfail][48]") { battery::none(answers().unknown); }

TEST_CASE("falling rates, steps end on the jumps: no more are wrong than known") {
  battery::at_most(known_known, answers().known);
}
TEST_CASE("falling rates, steps end on the jumps: none is wrong", "[!shouldfail][48]") {
  battery::none(answers().known);
}

// Where the ends of all steps are right.
TEST_CASE("falling rates, samples: no more are wrong than known") {
  battery::at_most(known_samples, answers().samples);
}
TEST_CASE("falling rates, samples: none is wrong", "[!shouldfail][48]") { battery::none(answers().samples); }

// Where the run without samples succeeds.
TEST_CASE("falling rates, runs with samples: no more fail than known") {
  battery::at_most(known_sampled_runs, answers().sampled_runs);
}
TEST_CASE("falling rates, runs with samples: none fails", "[!shouldfail][48]") {
  battery::none(answers().sampled_runs);
}
