// Rate equations whose components differ in size, by four schemes: with rtol alone, and with an atol by component.
#include "accuracy/mechanisms.hpp"

#include "support/battery.hpp"
#include "support/catch.hpp"

// Ceilings are a few above what is counted: a member near its limit may change with the compiler.
#if PHISTEP_STRESS
constexpr int members = 500;
#elif PHISTEP_FULL
constexpr int members = 100;
#endif
constexpr int known_moved = 1, known_refused = 1;  // counted 0 and 0

namespace {

using mechanisms::End, mechanisms::Member, mechanisms::Tallies;

End by_scheme(int scheme, const Member& m, const phistep::tolerance& control) {
  switch (scheme % 4) {
    case 0:
      return run(m.rates, m.start, m.time, phistep::radau, control);
    case 1:
      return run(m.rates, m.start, m.time, phistep::rodas4p2, control);
    case 2:
      return run(m.rates, m.start, m.time, phistep::rodas5p, control);
    default:
      return run(m.rates, m.start, m.time, phistep::tr_bdf2, control);
  }
}
/// Each member by one scheme, in turn.
const Tallies& family() {
  static const Tallies all = mechanisms::judge("mechanisms", members, by_scheme);
  return all;
}
const battery::Tally& named() {
  static const battery::Tally all = mechanisms::judge_named("named problems", 4, by_scheme);
  return all;
}

}  // namespace

TEST_CASE("mechanisms: the references agree") {
  figures::at_most(members / 50, family().skipped, "mechanisms", "skipped");
}

TEST_CASE("mechanisms, rtol alone: none beyond 100 kappa rtol") { battery::at_most(0, family().alone); }

TEST_CASE("mechanisms, rtol alone: other units move no more than known") {
  battery::at_most(known_moved, family().units);
}
// 2 % may be.
TEST_CASE("mechanisms, rtol alone: no more are refused than known") {
  battery::at_most(known_refused, family().refused);
}

TEST_CASE("mechanisms, atol by component: none beyond 100 kappa rtol") { battery::at_most(0, family().by_component); }

TEST_CASE("mechanisms, atol by component: none is wrong in other units") {
  battery::at_most(0, family().by_component_units);
}

TEST_CASE("named problems, rtol alone: none is wrong") { battery::at_most(0, named()); }

TEST_CASE("named problems: the references agree with published values") {
  for (Member& m : mechanisms::named_problems()) {
    const mechanisms::Vec published = m.name == "Robertson to 40" ? mechanisms::Vec(problems::Robertson::exact())
                                      : m.name == "Robertson to 1e+11"
                                          ? mechanisms::Vec(problems::Robertson::exact_late())
                                      : m.name == "HIRES"      ? mechanisms::Vec(problems::Hires::exact())
                                      : m.name == "Oregonator" ? mechanisms::Vec(problems::Oregonator::exact())
                                                               : mechanisms::Vec();
    if (published.size() == 0) continue;
    CAPTURE(m.name);
    REQUIRE(refer(m));
    CHECK((m.exact - published).cwiseQuotient(published).cwiseAbs().maxCoeff() < 1e-6);
  }
}
