#include <phistep/base/archive/archive.hpp>
#include <phistep/base/facts/structure.hpp>
#include <phistep/base/outcome/statistics.hpp>
#include <phistep/base/outcome/step_report.hpp>

#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <set>
#include <sstream>
#include <string>

#include "support/catch.hpp"

using namespace phistep;

TEST_CASE("every outcome has words of its own, and every failure an advice") {
  std::set<std::string> texts;
  for (int i = 0; i <= static_cast<int>(Outcome::exception_elsewhere); ++i) {
    const auto outcome = static_cast<Outcome>(i);
    CHECK(detail::OutcomeTexts::of(outcome).outcome == outcome);
    CHECK(texts.insert(describe(outcome)).second);
    const bool needs_advice =
        outcome != Outcome::success && outcome != Outcome::stopped_by_observer && outcome != Outcome::stopped_by_event;
    CHECK((std::string(advise(outcome)) != "") == needs_advice);
  }
}

TEST_CASE("a failure's message names component, particle, term, time, step, history and advice") {
  Failure f;
  f.outcome = Outcome::non_finite_force;
  f.t = 1.5, f.dt = 0.25, f.block = 1, f.index = 7, f.row = 1, f.column = 2, f.term = 3;
  f.add(0.5), f.add(0.125);
  CHECK_THAT(f.message(), contains("force is not finite") && contains("component 7") && contains("block 1") &&
                              contains("particle 2") && contains("row 1") && contains("term 3") &&
                              contains("t = 1.5") && contains("dt = 0.25") && contains("0.5 0.12") &&
                              contains("Try: "));
}

TEST_CASE("a long Newton history is cut, not written past its end") {
  Failure f;
  f.outcome = Outcome::newton_stalled;
  for (int i = 0; i < 100; ++i) f.add(1.0);
  CHECK(f.iterations == 100);
  CHECK_FALSE(f.message().empty());
}

TEST_CASE("a step report is true on success alone") {
  CHECK(StepReport{});
  CHECK(StepReport{}.message() == "phistep: success.");
  CHECK_FALSE(StepReport(Outcome::singular_matrix, 3, nullptr));
  CHECK(StepReport(Outcome::singular_matrix, 3, nullptr).iterations() == 3);
  CHECK_THAT(StepReport(Outcome::singular_matrix, 0, nullptr).message(), contains("singular"));
}

TEST_CASE("statistics subtract field by field and print their counts") {
  const Statistics a{.steps = 10,
                     .failed_steps = 2,
                     .force_calls = 30,
                     .jacobians = 4,
                     .factorizations = 5,
                     .analyses = 6,
                     .solves = 70,
                     .iterations = 80};
  const Statistics b{.steps = 1,
                     .failed_steps = 1,
                     .force_calls = 1,
                     .jacobians = 1,
                     .factorizations = 1,
                     .analyses = 1,
                     .solves = 1,
                     .iterations = 1};
  CHECK(a - b == Statistics{.steps = 9,
                            .failed_steps = 1,
                            .force_calls = 29,
                            .jacobians = 3,
                            .factorizations = 4,
                            .analyses = 5,
                            .solves = 69,
                            .iterations = 79});
  std::ostringstream out;
  out << a;
  CHECK_THAT(out.str(), contains("10  (and 2 failed)") && contains("30") && contains("70") && contains("80"));
}

TEST_CASE("every count is subtracted, added, printed and saved") {
  std::array<std::int64_t, sizeof(Statistics) / sizeof(std::int64_t)> numbers;
  std::iota(numbers.begin(), numbers.end(), 101);
  const auto all = std::bit_cast<Statistics>(numbers);
  CHECK(all - all == Statistics{});
  const auto twice_each = std::bit_cast<decltype(numbers)>(all + all);
  std::ostringstream out;
  out << all;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    CHECK(twice_each[i] == 2 * numbers[i]);
    CHECK_THAT(out.str(), contains(std::to_string(numbers[i])));
  }
  Writer writer;
  writer(all);
  Reader reader{writer.bytes()};
  Statistics read;
  reader(read);
  CHECK(read == all);
}

TEST_CASE("the structure of a sum holds that of both its terms") {
  using enum Structure;
  for (const Structure s : {none, diagonal, local, network, banded, dense, sparse}) {
    CHECK(combine(s, none) == s);
    CHECK(combine(none, s) == s);
    CHECK(combine(s, s) == s);
    CHECK(combine(s, sparse) == sparse);
  }
  CHECK(combine(dense, diagonal) == dense);
  CHECK(combine(local, dense) == dense);
  CHECK(combine(diagonal, local) == local);
  CHECK(combine(local, network) == network);
  CHECK(combine(banded, diagonal) == banded);
  // No one structure but the general one holds both of these.
  for (const Structure s : {local, network}) CHECK(combine(s, banded) == sparse);
  CHECK(combine(network, dense) == sparse);
  CHECK(combine(banded, dense) == dense);
}
