#include <phistep/base/archive/archive.hpp>
#include <phistep/base/state/motion.hpp>
#include <phistep/run/inside/dense_output.hpp>
#include <phistep/run/observers/at_times.hpp>
#include <phistep/run/observers/recorder.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

using One = Eigen::Matrix<double, 1, 1>;

/// Drives a sampler through steps of y = t² from t0, each dt long, the last one ending at t1 and perhaps shorter.
template <class Sampler>
void drive(Sampler& sampler, double t0, double dt, double t1) {
  DenseOutput<One> dense;
  One start{t0 * t0};
  if (!sampler.begin(t0, start)) return;
  for (int n = 0;; ++n) {
    const double from = t0 + n * dt, next = t0 + (n + 1) * dt;
    const bool last = (t1 - next) * dt <= 1e-9 * dt * dt;
    const double to = last ? t1 : next, length = std::abs(to - next) < 1e-9 ? dt : to - from;
    const One y0{from * from}, y1{to * to};
    const auto slopes = [&](One& s0, One& s1) { s0(0) = 2 * from, s1(0) = 2 * to; };
    dense.begin(from, length, to, y0, y1, slopes);
    if (!sampler(CompletedStep<One>(from, length, to, y0, y1, dense)) || last) return;
  }
}

/// Sampled times; every state is checked against t² by 4 roundings of its own size, and of the largest.
template <class Marks>
std::vector<double> samples(const Marks& marks, double t0, double dt, double t1) {
  std::vector<double> seen;
  auto sampler = sampled(marks, [&](double t, const One& y) {
    seen.push_back(t);
    CHECK(std::abs(y(0) - t * t) <= 16 * std::numeric_limits<double>::epsilon() * (t * t + dt * dt));
  });
  drive(sampler, t0, dt, t1);
  return seen;
}

}  // namespace

TEST_CASE("at_times: the next stop lies strictly ahead, forward and backward") {
  const auto observer = at_times({3.0, 0.1, 0.2, 0.1}, [](double, const One&) {});
  CHECK(observer.next_stop(-1.0, 0.5) == 0.1);
  CHECK(observer.next_stop(0.1, 0.5) == 0.2);
  CHECK(observer.next_stop(std::nextafter(0.1, 0.0), 0.5) == 0.1);
  CHECK(observer.next_stop(0.2, 0.5) == 3.0);
  CHECK_FALSE(observer.next_stop(3.0, 0.5));
  CHECK(observer.next_stop(4.0, -0.5) == 3.0);
  CHECK(observer.next_stop(3.0, -0.5) == 0.2);
  CHECK(observer.next_stop(0.2, -0.5) == 0.1);
  CHECK_FALSE(observer.next_stop(0.1, -0.5));
}

TEST_CASE("at_times: calls at its times alone, the start included, each once, run after run") {
  std::vector<double> seen;
  auto observer = at_times({0.3, 0.1, 0.1, 0.0}, [&](double t, const One&) { seen.push_back(t); });
  One y{1};
  for (int run = 0; run < 2; ++run) {
    seen.clear();
    for (const double t : {0.0, 0.05, 0.1, 0.1 + 0.2, 0.3}) CHECK(observer(t, y));
    CHECK(seen == std::vector<double>{0, 0.1, 0.3});  // 0.1 + 0.2 is not 0.3
  }
}

TEST_CASE("at_times: edits, asks for the end, takes any list of numbers") {
  One y{1};
  auto editor = at_times(std::vector<float>{0.5f}, [](double t, One& state) {
    state *= 2;
    return t < 0.4;
  });
  CHECK(editor(0.25, y));
  CHECK_FALSE(editor(0.5, y));
  CHECK(y(0) == 2);
  CHECK(at_times({1, 2}, [](double, const One&) {}).next_stop(1.0, 1.0) == 2.0);
  CHECK(at_times(Eigen::VectorXd::LinSpaced(5, 0, 1), [](double, const One&) {}).next_stop(0.25, 1.0) == 0.5);
  CHECK_FALSE(at_times(std::vector<double>{}, [](double, const One&) {}).next_stop(0.0, 1.0));
}

TEST_CASE("at_times: a state of floats stops at its own nearest numbers, one of longer ones at theirs") {
  const auto twice = at_times({0.1, 0.1 + 1e-12}, [](float, const One&) {});
  CHECK(twice.next_stop(0.0f, 1.0f) == 0.1f);
  CHECK_FALSE(twice.next_stop(0.1f, 1.0f));
  CHECK_FALSE(twice.next_stop(0.1f, -1.0f));
  CHECK(at_times(std::vector<long double>{0.1L}, [](long double, const One&) {}).next_stop(0.0L, 1.0L) == 0.1L);
}

TEST_CASE("times that are not finite, and intervals that are no interval, are refused") {
  const auto nothing = [](double, const auto&) {};
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    CHECK_THROWS_AS(at_times({0.0, bad}, nothing), std::invalid_argument);
    CHECK_THROWS_AS(sampled({bad, 0.0}, nothing), std::invalid_argument);
    CHECK_THROWS_AS(sampled(bad, nothing), std::invalid_argument);
  }
  CHECK_THROWS_AS(sampled(0.0, nothing), std::invalid_argument);
  CHECK_THROWS_AS(sampled(-1.0, nothing), std::invalid_argument);
}

TEST_CASE("sampled: at every multiple of the interval, whatever the steps, both ends included") {
  for (const double dt : {0.03, 0.1, 0.25, 7.0}) {
    const auto seen = samples(0.1, 0.2, dt, 1.2);
    REQUIRE(seen.size() == 11);
    for (int k = 0; k <= 10; ++k) CHECK(seen[static_cast<std::size_t>(k)] == 0.2 + k * 0.1);
  }
  // 3 · 0.1 lies a rounding after 0.3, where the run ends.
  REQUIRE(3 * 0.1 > 0.3);
  CHECK(samples(0.1, 0, 0.1, 0.3).size() == 4);
}

TEST_CASE("sampled: backward") {
  const auto seen = samples(0.5, 1, -0.3, -1);
  CHECK(seen == std::vector<double>{1, 0.5, 0, -0.5, -1});
}

TEST_CASE("sampled: given times to the last bit, in order, once, those outside left out") {
  const std::vector<double> times{0.3, -5, 0.1, 0.75, 0.3, 0.5, 2};
  CHECK(samples(times, 0.1, 0.2, 1) == std::vector<double>{0.1, 0.3, 0.5, 0.75});
  CHECK(samples(times, 0, 10, 1) == std::vector<double>{0.1, 0.3, 0.5, 0.75});
  CHECK(samples(times, 1, -0.25, 0.3) == std::vector<double>{0.75, 0.5, 0.3});
}

TEST_CASE("sampled: a second run starts clean, and a wish to stop is passed on") {
  std::vector<double> seen;
  auto sampler = sampled(0.25, [&](double t, const One&) {
    seen.push_back(t);
    return t < 0.5;
  });
  for (int run = 0; run < 2; ++run) {
    seen.clear();
    drive(sampler, 0, 0.3, 1);
    CHECK(seen == std::vector<double>{0, 0.25, 0.5});
  }
  auto at_once = sampled({0.0}, [](double, const One&) { return false; });
  CHECK_FALSE(at_once.begin(0.0, One{1}));
}

TEST_CASE("sampled: looks at whole steps, not at (t, state); a recorder by reference serves it") {
  Recorder<One> recorder;
  auto sampler = sampled(0.5, std::ref(recorder));
  static_assert(std::is_invocable_v<decltype(sampler)&, const CompletedStep<One>&>);
  static_assert(!std::is_invocable_v<decltype(sampler)&, double, One&>);
  drive(sampler, 0, 0.2, 2);
  CHECK(recorder.size() == 5);
}

TEST_CASE("sampled: more often than time has numbers is refused at the start of a run") {
  int calls = 0;
  auto often = phistep::sampled(1e-12, [&](double, int) { ++calls; });
  CHECK_THROWS_AS(often.begin(1e9, 0), std::invalid_argument);
  CHECK_THROWS_AS(often.begin(-1e9f, 0), std::invalid_argument);
  CHECK(calls == 0);
  CHECK(often.begin(1e3, 0));
  CHECK(calls == 1);
}

TEST_CASE("sampled: a checkpoint holds how far it has come; a time that isn't finite is refused") {
  const auto copied = [](auto from, auto to) {
    Writer out;
    out(from);
    Reader in{out.bytes()};
    in(to);
    in.finish();
    return to;
  };
  const ListMarks fresh{TimeList({1.0, 2.0, 3.0})};
  ListMarks marks = fresh;
  CHECK_FALSE(marks.begin(0.5));
  marks.pass(2.0);
  CHECK(copied(marks, fresh).next(0.1) == 3.0);
  const IntervalMarks unused(0.5);
  IntervalMarks regular = unused;
  CHECK(regular.begin(4.0));
  regular.pass(4.5);
  CHECK(copied(regular, unused).next(0.1) == 5.0);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    marks.pass(bad);
    CHECK_THROWS_AS(copied(marks, fresh), CheckpointError);
    static_cast<void>(regular.begin(bad));
    CHECK_THROWS_AS(copied(regular, unused), CheckpointError);
  }
}
