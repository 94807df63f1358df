#include <phistep/base/state/motion.hpp>
#include <phistep/run/observers/event.hpp>
#include <phistep/run/observers/recorder.hpp>

#include <functional>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {
using One = Eigen::Matrix<double, 1, 1>;
}

TEST_CASE("event: its function sees the state, or time and state") {
  auto of_state = event([](const auto& y) { return y(0) - 1; });
  auto of_both = event([](double t, const One& y) { return t * y(0); });
  CHECK(of_state.value(2.0, One{3}) == 2);
  CHECK(of_both.value(2.0, One{3}) == 6);
  auto in_float = event([](float t, const auto& y) { return static_cast<double>(t * y(0)); });
  static_assert(std::is_same_v<decltype(in_float.value(2.0f, Eigen::Matrix<float, 1, 1>{3.0f})), float>);
  CHECK(in_float.value(2.0f, Eigen::Matrix<float, 1, 1>{3.0f}) == 6);
}

TEST_CASE("event: keeps its times, of one run") {
  auto e = event([](const One& y) { return y(0); });
  One y{0};
  CHECK(e.happened(1.0, y));
  CHECK(e.happened(2.0, y));
  CHECK(e.times() == std::vector<double>{1, 2});
  e.begin(0);
  CHECK(e.times().empty());
}

TEST_CASE("event: ends the run where it is terminal, or where its handler says so") {
  const auto g = [](const One& y) { return y(0); };
  One y{1};
  auto plain = event(g, {.direction = Direction::rising});
  CHECK(plain.options().direction == Direction::rising);
  CHECK(plain.happened(0.0, y));
  auto terminal = event(g, {.terminal = true});
  CHECK_FALSE(terminal.happened(0.0, y));
  auto handled = event(g, {}, [](double, One& state) { state *= 2; });
  CHECK(handled.happened(0.0, y));
  CHECK(y(0) == 2);
  auto asks = event(g, [](double t, const One&) { return t < 1; });  // options left out
  CHECK(asks.happened(0.5, y));
  CHECK_FALSE(asks.happened(1.5, y));
  auto both = event(g, {.terminal = true}, [](double, One& state) { state *= 2; });
  CHECK_FALSE(both.happened(0.0, y));
  CHECK(y(0) == 4);
  Recorder<One> recorder;
  auto records = event(g, {}, std::ref(recorder));
  CHECK(records.happened(0.5, y));
  CHECK(recorder.size() == 1);
}

TEST_CASE("event: told from an observer by its type") {
  auto e = event([](const One& y) { return y(0); });
  static_assert(EventLike<decltype(e)> && EventLike<decltype(e)&>);
  static_assert(!EventLike<Recorder<One>>);
  CHECK(sizeof(Event<int (*)(const One&)>) <= sizeof(void*) + sizeof(EventOptions) + sizeof(std::vector<double>) + 16);
}
