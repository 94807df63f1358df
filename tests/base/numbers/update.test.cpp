#include <phistep/base/machine/loop_hints.hpp>
#include <phistep/base/numbers/fingerprint.hpp>
#include <phistep/base/numbers/update.hpp>
#include <phistep/step/in_place/in_place_update.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "support/catch.hpp"
#include "support/threads.hpp"

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

// From some length on the outputs of a kernel for packets bypass the caches, where they are aligned.
TEST_CASE("update does the same to large arrays, whatever their length and alignment") {
  const std::ptrdiff_t large = 2 * stream_from() / static_cast<std::ptrdiff_t>(sizeof(double));
  std::vector<double> in(static_cast<std::size_t>(large)), a(in.size()), b(in.size());
  for (std::size_t i = 0; i < in.size(); ++i) in[i] = static_cast<double>(i);
  std::vector<double> other = in;
  const Input x0{static_cast<const double*>(in.data())}, y0{static_cast<const double*>(other.data())};
  for (const std::ptrdiff_t offset : {0, 1})
    for (const std::ptrdiff_t n : {large - 2, large - 61, large - 64}) {
      const auto run = [&] {
        return update(
            n, [=](auto i, auto& x, auto& y) { x = x0[i], y = -1.0 * y0[i]; }, a.data() + offset, b.data() + offset);
      };
      CAPTURE(offset, n);
      std::fill(a.begin(), a.end(), -7), std::fill(b.begin(), b.end(), -7);
      REQUIRE(run());
      bool exact = true;
      for (std::ptrdiff_t i = 0; i < n; ++i) {
        const auto x = static_cast<double>(i);
        exact = exact && a[static_cast<std::size_t>(i + offset)] == x && b[static_cast<std::size_t>(i + offset)] == -x;
      }
      CHECK(exact);
      CHECK(a[static_cast<std::size_t>(n + offset)] == -7);  // nothing behind the end
      for (std::vector<double>* const input : {&in, &other})
        for (const std::ptrdiff_t where : {std::ptrdiff_t{0}, n / 2, n - 1}) {
          double& value = (*input)[static_cast<std::size_t>(where)];
          const double kept = std::exchange(value, std::nan(""));
          CHECK_FALSE(run());
          value = kept;
        }
    }
}

TEST_CASE("threads share large arrays, in the caches and beyond, and change no bit") {
  for (const std::ptrdiff_t n :
       {2 * static_cast<std::ptrdiff_t>(shared_from) + 61, stream_from() / std::ptrdiff_t{sizeof(double)} + 61}) {
    std::vector<double> in(static_cast<std::size_t>(n)), out(in.size()), one;
    for (std::size_t i = 0; i < in.size(); ++i) in[i] = std::sin(static_cast<double>(i));
    const Input x0{static_cast<const double*>(in.data())};
    const auto square = [=](auto i, auto& x) { x = 1.1 + x0[i] * x0[i]; };
    std::uint64_t print = 0;
    for (const int threads : {1, 2, 3, 5}) {
      const phistep_test::Threads some{threads};
      CAPTURE(n, threads);
      std::fill(out.begin(), out.end(), -7);
      CHECK(update(n, square, out.data()));
      if (threads == 1) one = out;
      CHECK(out == one);
      std::fill(out.begin(), out.end(), -7);
      CHECK(update_in_place(n, square, out.data()));
      CHECK(out == one);
      std::fill(out.begin(), out.end(), -7);
      update_in_place_unwatched(n, square, out.data());
      CHECK(out == one);
      if (threads == 1) print = fingerprint(in.data(), n);
      CHECK(fingerprint(in.data(), n) == print);
      for (const std::ptrdiff_t where : {std::ptrdiff_t{0}, n / 2 - 1, n / 2, n - 1}) {
        double& value = in[static_cast<std::size_t>(where)];
        const double kept = std::exchange(value, std::nan(""));
        CHECK_FALSE(update(n, square, out.data()));
        CHECK_FALSE(update_in_place(n, square, out.data()));
        CHECK(fingerprint(in.data(), n) != print);
        value = kept;
      }
    }
    Fingerprint whole;
    whole.add(in.data(), n * std::ptrdiff_t{sizeof(double)});
    CHECK(print == whole.value());
  }
}

TEST_CASE("the last cache is one that there is, and is asked for once") {
  CHECK(last_cache() >= std::ptrdiff_t{64} << 10);
  CHECK(last_cache() <= std::ptrdiff_t{4} << 30);
  CHECK(stream_from() == last_cache() / 16 * 3);
}

// A kernel for packets: on the baseline numbers come two at a time, and an odd one alone.
TEMPLATE_TEST_CASE("update in place, watched or not, is the same at every length", "", float, double, long double) {
  const auto inf = std::numeric_limits<TestType>::infinity();
  for (std::ptrdiff_t n = 0; n <= 40; ++n) {
    std::vector<TestType> x(static_cast<std::size_t>(n)), y(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<TestType>(i + 1), y[i] = -3 * x[i];
    const auto first = x, second = y;
    const Input in{static_cast<const TestType*>(x.data())}, more{static_cast<const TestType*>(y.data())};
    const auto swap_and_double = [in, more](auto i, auto& a, auto& b) { a = more[i] + more[i], b = in[i] + in[i]; };
    CAPTURE(n);
    CHECK(update_in_place(n, swap_and_double, x.data(), y.data()));
    update_in_place_unwatched(n, swap_and_double, x.data(), y.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      CHECK(x[i] == 4 * first[i]);
      CHECK(y[i] == 4 * second[i]);
    }
    for (std::size_t i = 0; i < x.size(); ++i)
      for (auto* const array : {&x, &y}) {
        CAPTURE(i);
        const TestType kept = std::exchange((*array)[i], inf);
        CHECK_FALSE(update_in_place(n, swap_and_double, x.data(), y.data()));
        std::swap(x, y);  // the infinity went to the other one
        (*array)[i] = kept;
      }
  }
}

TEMPLATE_TEST_CASE("the sum of magnitudes is a bound, and not finite where a number isn't", "", float, double,
                   long double) {
  using Limits = std::numeric_limits<TestType>;
  for (std::ptrdiff_t n = 0; n <= 100; ++n) {
    std::vector<TestType> x(static_cast<std::size_t>(n));
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<TestType>(i) * (i % 2 == 0 ? 1 : -1);
    const auto sum = [&] { return sum_of_magnitudes(static_cast<const TestType*>(x.data()), n); };
    CAPTURE(n);
    CHECK(sum() == static_cast<TestType>(n * (n - 1) / 2));
    for (TestType& value : x) {
      const TestType kept = value;
      for (const TestType one : {Limits::max(), Limits::lowest(), Limits::denorm_min(), -TestType{1e30f}}) {
        value = one;
        CHECK(sum() >= std::abs(one));
      }
      for (const TestType bad : {Limits::quiet_NaN(), -Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
        value = bad;
        CHECK_FALSE(std::isfinite(sum()));
      }
      value = kept;
    }
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
