#include <phistep/base/archive/archive.hpp>
#include <phistep/base/state/motion.hpp>
#include <phistep/run/observers/at_times.hpp>
#include <phistep/run/observers/recorder.hpp>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {
std::vector<double> seen_by_every(double interval, double t0, double dt, int steps) {
  std::vector<double> seen;
  auto observer = every(interval, [&seen](double t, const auto&) { seen.push_back(t); });
  const Eigen::Vector2d y(1, 2);
  for (int n = 0; n <= steps; ++n) CHECK(observer(t0 + n * dt, y));
  return seen;
}
}  // namespace

TEST_CASE("every: at the start, then at each multiple, rounding aside") {
  // From 1.1 in steps of 0.1, some step ends fall short of a multiple of 0.5 by a rounding.
  const auto seen = seen_by_every(0.5, 1.1, 0.1, 1000);
  REQUIRE(seen.size() == 201);
  for (std::size_t k = 0; k < seen.size(); ++k)
    CHECK(seen[k] == Approx(1.1 + 0.5 * static_cast<double>(k)).margin(1e-12));
}

TEST_CASE("every: the first step end after a mark that no step meets") {
  const auto seen = seen_by_every(0.25, 10, 0.1, 10);
  REQUIRE(seen.size() == 5);
  CHECK(seen[1] == Approx(10.3));
  CHECK(seen[2] == Approx(10.5));
  CHECK(seen[3] == Approx(10.8));
  CHECK(seen[4] == Approx(11.0));
}

TEST_CASE("every: steps longer than the interval are each shown once") {
  CHECK(seen_by_every(0.1, 0, 1, 5).size() == 6);
  for (const double short_one : {1e-20, 1e-300, 5e-324})  // more marks than can be counted
    CHECK(seen_by_every(short_one, 0, 1, 5).size() == 6);
}

TEST_CASE("every: backward runs too") {
  const auto seen = seen_by_every(0.5, 3, -0.1, 20);
  REQUIRE(seen.size() == 5);
  CHECK(seen[1] == Approx(2.5));
}

TEST_CASE("every: an interval must be finite and > 0") {
  const auto nothing = [](double, const auto&) {};
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL})
    CHECK_THROWS_AS(every(bad, nothing), std::invalid_argument);
}

TEST_CASE("every: passes on the wish to stop") {
  auto stop_at_half = every(0.5, [](double t, const auto&) { return t < 0.4; });
  const Eigen::Vector2d y(1, 2);
  CHECK(stop_at_half(0.0, y));
  CHECK(stop_at_half(0.3, y));
  CHECK_FALSE(stop_at_half(0.6, y));
}

TEST_CASE("every: may edit the state") {
  auto edit = every(1.0, [](double, Eigen::Vector2d& y) { y *= 2; });
  Eigen::Vector2d y(1, 2);
  for (const double t : {0.0, 0.5, 1.0}) CHECK(edit(t, y));
  CHECK(y == Eigen::Vector2d(4, 8));
}

TEST_CASE("every: goes on after a restart with the mark that it waited for") {
  std::vector<double> seen;
  const auto look = [&seen](double t, const auto&) { seen.push_back(t); };
  const Eigen::Vector2d y(1, 2);
  auto before = every(0.5, look), after = every(0.5, look);
  for (const double t : {3.0, 3.25, 3.5}) CHECK(before(t, y));
  Writer out;
  out.save(before);
  Reader in{out.bytes()};
  in.load(after);
  seen.clear();
  for (const double t : {3.75, 4.0, 4.25, 4.75}) CHECK(after(t, y));
  CHECK(seen == std::vector<double>{4.0, 4.75});
}

TEST_CASE("every: a checkpoint that can't be of it is refused, and changes nothing") {
  const Eigen::Vector2d y(1, 2);
  const auto load = [&](double start, long long next) {
    int seen = 0;
    auto observer = every(0.5, [&seen](double, const auto&) { ++seen; });
    CHECK(observer(3.0, y));
    Writer out;
    out.open("0");
    out.open("marks");
    out("start", static_cast<long double>(start), "next", next);
    out.close();
    out("first", false);
    out.close();
    Reader in{out.bytes()};
    try {
      in.load(observer);
    } catch (const CheckpointError&) {
      CHECK(observer(3.25, y));
      CHECK(seen == 1);
      return false;
    }
    return true;
  };
  CHECK(load(3.0, 1));
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) CHECK_FALSE(load(bad, 1));
  for (const long long bad : {-1LL, (1LL << 53) + 1}) CHECK_FALSE(load(3.0, bad));
}

TEST_CASE("a recorder keeps all blocks of every state, one column a time") {
  Recorder<Motion<Eigen::Vector2d>> recorder;
  CHECK(recorder.size() == 0);
  CHECK(recorder.states().size() == 0);
  recorder(0.0, Motion<Eigen::Vector2d>{Eigen::Vector2d(1, 2), Eigen::Vector2d(3, 4)});
  recorder(0.5, Motion<Eigen::Vector2d>{Eigen::Vector2d(5, 6), Eigen::Vector2d(7, 8)});
  CHECK(recorder.times() == Eigen::Vector2d(0, 0.5));
  CHECK(recorder.states() == (Eigen::MatrixXd(4, 2) << 1, 5, 2, 6, 3, 7, 4, 8).finished());
  recorder.clear();
  CHECK(recorder.size() == 0);
}

TEST_CASE("a recorder's blocks, one column a time, and its shapes") {
  using S = Motion<Eigen::Matrix<double, 2, Eigen::Dynamic>>;
  Recorder<S> recorder;
  S y{Eigen::MatrixXd::Zero(2, 2), Eigen::MatrixXd::Zero(2, 2)};
  y.r << 1, 3, 2, 4;
  y.v << 5, 7, 6, 8;
  recorder(0.0, y);
  y.r *= 10;
  recorder(0.5, y);
  CHECK(recorder.position() == (Eigen::MatrixXd(4, 2) << 1, 10, 2, 20, 3, 30, 4, 40).finished());
  CHECK(recorder.velocity() == (Eigen::MatrixXd(4, 2) << 5, 5, 6, 6, 7, 7, 8, 8).finished());
  CHECK(recorder.block(1).col(1).reshaped(2, 2) == y.v);
  CHECK(recorder.shape(0) == std::pair<Eigen::Index, Eigen::Index>{2, 2});
  CHECK_THROWS_AS(recorder.block(2), std::out_of_range);

  const S larger{Eigen::MatrixXd::Zero(2, 3), Eigen::MatrixXd::Zero(2, 3)};
  CHECK_THROWS_AS(recorder(1.0, larger), std::invalid_argument);
  CHECK(recorder.size() == 2);
  recorder.clear();
  CHECK(recorder.position().size() == 0);
  recorder(1.0, larger);
  CHECK(recorder.position().rows() == 6);
}

TEST_CASE("a recorder by reference serves every") {
  Recorder<Eigen::Vector2d> recorder;
  auto observer = every(1.0, std::ref(recorder));
  const Eigen::Vector2d y(1, 2);
  for (int n = 0; n <= 20; ++n) CHECK(observer(0.1 * n, y));
  CHECK(recorder.size() == 3);
}
