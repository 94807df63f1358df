// Rate equations whose components differ in size, without a stepper: with rtol alone, and with an atol by component.
#if defined(__GNUC__) && !defined(__clang__)
// g++ 12 at -O2 takes what a stepper without an implicit part never fills for used where the chosen one is replaced.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <phistep/automatic.hpp>

#include "accuracy/mechanisms.hpp"

#include "support/battery.hpp"
#include "support/catch.hpp"

// Ceilings are a few above what is counted: a member near its limit may change with the compiler.
constexpr int members = 500;
constexpr int known_moved = 1, known_refused = 1;  // counted 0 and 0

namespace {

using mechanisms::End, mechanisms::Member, mechanisms::Tallies;

End automatic(int /*number*/, const Member& m, const phistep::tolerance& control) {
  mechanisms::Vec y = m.start.cwiseProduct(m.rates.unit);
  const phistep::RunReport report = phistep::integrate(y, m.rates, {0, m.time}, control);
  return {report, y.cwiseQuotient(m.rates.unit), y};
}
const Tallies& family() {
  static const Tallies all = mechanisms::judge("mechanisms without a stepper", members, automatic);
  return all;
}
const battery::Tally& named() {
  static const battery::Tally all = mechanisms::judge_named("named problems without a stepper", 1, automatic);
  return all;
}

}  // namespace

TEST_CASE("mechanisms without a stepper: the references agree") {
  figures::at_most(members / 50, family().skipped, "mechanisms", "skipped");
}

TEST_CASE("mechanisms without a stepper, rtol alone: none beyond 100 kappa rtol") {
  battery::at_most(0, family().alone);
}

TEST_CASE("mechanisms without a stepper, rtol alone: other units move no more than known") {
  battery::at_most(known_moved, family().units);
}

// 2 % may be.
TEST_CASE("mechanisms without a stepper, rtol alone: no more are refused than known") {
  battery::at_most(known_refused, family().refused);
}

TEST_CASE("mechanisms without a stepper, atol by component: none beyond 100 kappa rtol") {
  battery::at_most(0, family().by_component);
}

TEST_CASE("mechanisms without a stepper, atol by component: none is wrong in other units") {
  battery::at_most(0, family().by_component_units);
}

TEST_CASE("named problems without a stepper, rtol alone: none is wrong") { battery::at_most(0, named()); }
