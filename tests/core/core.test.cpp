#include <phistep/core/archive.hpp>
#include <phistep/core/arithmetic.hpp>
#include <phistep/core/fingerprint.hpp>
#include <phistep/core/statistics.hpp>
#include <phistep/core/step_report.hpp>
#include <phistep/core/structure.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

TEST_CASE("all_finite finds one bad value at every place of every length") {
  const double bad_values[] = {std::nan(""), HUGE_VAL, -HUGE_VAL};
  for (std::size_t n = 0; n <= 40; ++n) {
    std::vector<double> x(n, 1e308);  // the sum of the values themselves overflows
    CHECK(all_finite(x.data(), static_cast<std::ptrdiff_t>(n)));
    for (std::size_t i = 0; i < n; ++i)
      for (const double bad : bad_values) {
        x[i] = bad;
        CAPTURE(n, i, bad);
        CHECK_FALSE(all_finite(x.data(), static_cast<std::ptrdiff_t>(n)));
        x[i] = -1e308;
      }
  }
}

/// out = 2·in, with `bad` at index `where` (−1: nowhere). The return value of update.
template <class Scalar>
[[nodiscard]] bool twice(std::ptrdiff_t n, const Scalar* in, Scalar* out, std::ptrdiff_t where, Scalar bad) {
  return update(
      n, [=](std::ptrdiff_t i, Scalar& x) { x = i == where ? bad : 2 * in[i]; }, out);
}

TEMPLATE_TEST_CASE("update writes every element and finds one bad value at every place", "", float, double,
                   long double) {
  const auto inf = std::numeric_limits<TestType>::infinity(), largest = std::numeric_limits<TestType>::max() / 2;
  for (std::ptrdiff_t n = 0; n <= 40; ++n) {
    const auto size = static_cast<std::size_t>(n);
    const std::vector<TestType> in(size, largest);  // their sum overflows
    std::vector<TestType> out(size, 0);
    CHECK(twice(n, in.data(), out.data(), -1, inf));
    CHECK(out == std::vector<TestType>(size, 2 * largest));
    for (std::ptrdiff_t i = 0; i < n; ++i)
      for (const TestType bad : {inf, -inf, std::numeric_limits<TestType>::quiet_NaN()}) {
        CAPTURE(n, i, bad);
        CHECK_FALSE(twice(n, in.data(), out.data(), i, bad));
      }
  }
}

// From some length on the outputs bypass the caches in blocks, where they are aligned; the last few are written plainly.
TEST_CASE("update does the same to large arrays, whatever their length and alignment") {
  const std::ptrdiff_t large = 2 * stream_from / static_cast<std::ptrdiff_t>(sizeof(double));
  std::vector<double> in(static_cast<std::size_t>(large)), a(in.size()), b(in.size());
  for (std::size_t i = 0; i < in.size(); ++i) in[i] = static_cast<double>(i);
  for (const std::ptrdiff_t offset : {0, 1})
    for (const std::ptrdiff_t n : {large - 2, large - 61, large - 64}) {
      const auto run = [&](std::ptrdiff_t where) {
        return update(
            n,
            [&in, where](std::ptrdiff_t i, double& x, double& y) {
              x = in[static_cast<std::size_t>(i)];
              y = i == where ? std::nan("") : -x;
            },
            a.data() + offset, b.data() + offset);
      };
      CAPTURE(offset, n);
      std::fill(a.begin(), a.end(), -7), std::fill(b.begin(), b.end(), -7);
      REQUIRE(run(-1));
      bool exact = true;
      for (std::ptrdiff_t i = 0; i < n; ++i) {
        const auto x = static_cast<double>(i);
        exact = exact && a[static_cast<std::size_t>(i + offset)] == x && b[static_cast<std::size_t>(i + offset)] == -x;
      }
      CHECK(exact);
      CHECK(a[static_cast<std::size_t>(n + offset)] == -7);  // nothing behind the end
      for (const std::ptrdiff_t where : {std::ptrdiff_t{0}, n / 2, n - 1}) CHECK_FALSE(run(where));
    }
}

TEST_CASE("an output of update may be its input") {
  std::vector<double> x(1000, 1), y(1000, 2);
  CHECK(update(
      1000,
      [&](std::ptrdiff_t i, double& a, double& b) {
        const auto k = static_cast<std::size_t>(i);
        a = y[k] + 1;
        b = x[k] + 10;
      },
      x.data(), y.data()));
  CHECK(x == std::vector<double>(1000, 3));
  CHECK(y == std::vector<double>(1000, 11));
}

TEST_CASE("update_unrolled finds a bad value in either output") {
  double a[3], b[3];
  const auto run = [&](double x, double y) {
    return update_unrolled<3>(
        [=](std::ptrdiff_t i, double& p, double& q) { p = i == 1 ? x : 1e308, q = i == 2 ? y : 1e308; }, a, b);
  };
  CHECK(run(5, 6));
  CHECK(a[1] == 5);
  CHECK(b[2] == 6);
  CHECK_FALSE(run(std::nan(""), 0));
  CHECK_FALSE(run(0, HUGE_VAL));
}

TEST_CASE("a fingerprint changes with any bit, with the order and with the length") {
  std::vector<double> x{1, 2, 3, 4, 5, 6, 7, 8, 9};
  const auto n = static_cast<std::ptrdiff_t>(x.size());
  const std::uint64_t original = fingerprint(x.data(), n);
  CHECK(fingerprint(x.data(), n) == original);
  CHECK(fingerprint(x.data(), n - 1) != original);
  CHECK(fingerprint(x.data(), n, 1) != original);
  for (double& value : x) {
    const double kept = value;
    value = std::nextafter(kept, 10.0);
    CHECK(fingerprint(x.data(), n) != original);
    value = -kept;
    CHECK(fingerprint(x.data(), n) != original);
    value = kept;
  }
  std::swap(x[2], x[7]);
  CHECK(fingerprint(x.data(), n) != original);
}

TEST_CASE("fingerprints of float and long double see every bit too") {
  float f = 1.0f;
  const auto before = fingerprint(&f, 1);
  f = std::nextafter(f, 2.0f);
  CHECK(fingerprint(&f, 1) != before);
  long double l = 1.0L;
  const auto long_before = fingerprint(&l, 1);
  l = std::nextafter(l, 2.0L);
  CHECK(fingerprint(&l, 1) != long_before);
  l = 2.0L;  // on x87 the mantissa is that of 1
  CHECK(fingerprint(&l, 1) != long_before);
}

TEST_CASE("every outcome has words of its own, and every failure an advice") {
  std::set<std::string> texts;
  for (int i = 0; i <= static_cast<int>(Outcome::wrong_size); ++i) {
    const auto outcome = static_cast<Outcome>(i);
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
  f.record(0.5), f.record(0.125);
  CHECK_THAT(f.message(), contains("force is not finite") && contains("component 7") && contains("block 1") &&
                              contains("particle 2") && contains("row 1") && contains("term 3") &&
                              contains("t = 1.5") && contains("dt = 0.25") && contains("0.5 0.12") &&
                              contains("Try: "));
}

TEST_CASE("a long Newton history is cut, not written past its end") {
  Failure f;
  f.outcome = Outcome::newton_stalled;
  for (int i = 0; i < 100; ++i) f.record(1.0);
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
  for (const Structure s : {none, diagonal, local, network, block_tridiagonal, banded, dense, sparse}) {
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
  for (const Structure s : {local, network, block_tridiagonal}) CHECK(combine(s, banded) == sparse);
  CHECK(combine(network, dense) == sparse);
  CHECK(combine(banded, dense) == dense);
}
