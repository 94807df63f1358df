// Rate equations whose components differ in size, the scheme chosen by the library: with rtol alone, and with an atol by component.
#include <phistep/automatic.hpp>

#include "accuracy/mechanisms.hpp"

#include "support/battery.hpp"
#include "support/catch.hpp"

#if PHISTEP_STRESS
constexpr int members = 500;
constexpr int known_wrong = 0, known_moved = 0, known_refused = 0, known_in_other_units = 0;
#elif PHISTEP_FULL
constexpr int members = 100;
constexpr int known_wrong = 0, known_moved = 0, known_refused = 0, known_in_other_units = 0;
#endif
constexpr int known_named = 0;

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

TEST_CASE("mechanisms without a stepper: the references agree") { figures::at_most(members / 50, family().skipped, "mechanisms", "skipped"); }

TEST_CASE("mechanisms without a stepper, rtol alone: no more beyond 100 kappa rtol than known") {
  battery::at_most(known_wrong, family().alone);
}
TEST_CASE("mechanisms without a stepper, rtol alone: none beyond 100 kappa rtol", "[!shouldfail][46-A]") { battery::none(family().alone); }

TEST_CASE("mechanisms without a stepper, rtol alone: other units move no more than known") {
  battery::at_most(known_moved, family().units);
}
TEST_CASE("mechanisms without a stepper, rtol alone: other units move none", "[!shouldfail][46-A]") { battery::none(family().units); }

TEST_CASE("mechanisms without a stepper, rtol alone: no more are refused than known") {
  battery::at_most(known_refused, family().refused);
}
TEST_CASE("mechanisms without a stepper, rtol alone: at most 2 % are refused", "[!shouldfail][46-A]") {
  CHECK(family().refused.wrong <= members / 50);
}

TEST_CASE("mechanisms without a stepper, atol by component: none beyond 100 kappa rtol") { battery::at_most(0, family().by_component); }

TEST_CASE("mechanisms without a stepper, atol by component: no more are wrong in other units than known") {
  battery::at_most(known_in_other_units, family().by_component_units);
}
#if PHISTEP_STRESS
TEST_CASE("mechanisms without a stepper, atol by component: none is wrong in other units", "[!shouldfail][46-A]") {
  battery::none(family().by_component_units);
}
#endif

TEST_CASE("named problems without a stepper, rtol alone: no more are wrong than known") { battery::at_most(known_named, named()); }
TEST_CASE("named problems without a stepper, rtol alone: none is wrong", "[!shouldfail][46-A]") { battery::none(named()); }

