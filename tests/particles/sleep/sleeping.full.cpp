#include <phistep/particles.hpp>
#include <phistep/particles/sleep/sleeping.hpp>

#include <cmath>
#include <sstream>
#include <tuple>
#include <utility>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Grains = Particles<double, 2>;

namespace {

/// Soft discs of diameter 1 with dashpots, on a soft floor: overdamped enough to come to rest.
struct Pile : ForceTerm {
  double k = 1000, c = 20;
  std::int64_t* rows = nullptr;  // counts particles whose force was computed
  static constexpr bool uses_velocity = true, uses_time = false;
  static constexpr const char* name = "watcher";
  struct Memory {
    static constexpr bool is_cache = true;
    mutable Eigen::Matrix2Xd seen;
    void archive(auto& ar) { ar(seen); }
  };
  static void commit(auto, const auto&, Memory&) {}
  void add(auto, const auto& y, const Memory& memory, auto& out) const {
    memory.seen = y.r;
    for (Index i = 0; i < y.r.cols(); ++i) {
      if (y.body.is_still(i)) continue;
      if (rows != nullptr) ++*rows;
      if (const double depth = 0.5 - y.r(1, i); depth > 0) {
        out.force(1, i) += k * depth - c * y.v(1, i);
        out.force(0, i) -= c * y.v(0, i);
      }
      for (Index j = 0; j < y.r.cols(); ++j) {
        const Eigen::Vector2d d = y.r.col(i) - y.r.col(j);
        const double distance = d.norm();
        if (j == i || distance >= 1) continue;
        const Eigen::Vector2d n = d / distance;
        out.force.col(i) += k * (1 - distance) * n - c * (y.v.col(i) - y.v.col(j));
      }
    }
  }
  void for_each_pair(const Memory& memory, auto&& f) const {
    for (Index i = 0; i < memory.seen.cols(); ++i)
      for (Index j = i + 1; j < memory.seen.cols(); ++j)
        if ((memory.seen.col(i) - memory.seen.col(j)).squaredNorm() < 1.21) f(i, j);
  }
};

/// n columns of 4 discs each, a diameter and a half apart, resting but for rounding of their compression.
Grains columns(int n) {
  Grains grains{Eigen::Matrix2Xd(2, 4 * n)};
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < 4; ++b) grains.r.col(4 * a + b) << 1.5 * a, 0.49 + 0.98 * b;
  grains.v.setZero(2, 4 * n);
  return grains;
}
auto scene(std::int64_t* rows = nullptr) {
  Pile pile;
  pile.rows = rows;
  return pile + Gravity{Eigen::Vector2d{0, -10}};
}
constexpr double dt = 1e-3;
/// Falls as long as a test lasts: where everything sleeps, every change wakes all.
Grains faller() { return Grains{Eigen::Vector2d{100, 1e6}}; }

}  // namespace

TEST_CASE("a scene that has come to rest falls asleep, and then nothing at all is computed") {
  Grains grains = columns(2);
  std::int64_t rows = 0;
  Sleeping stepper{PhiStepper{grains, scene(&rows), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  while (stepper.report().asleep < grains.size() && n < 20000) REQUIRE(stepper.step(grains, dt * n++, dt));
  REQUIRE(stepper.report().asleep == grains.size());
  CHECK(grains.v == Eigen::Matrix2Xd::Zero(2, 8));
  const auto before = stepper.statistics();
  const std::int64_t rows_before = rows;
  const Eigen::Matrix2Xd r = grains.r;
  for (int k = 0; k < 50; ++k) REQUIRE(stepper.step(grains, dt * n++, dt));
  CHECK(rows == rows_before);
  CHECK(stepper.statistics().force_calls == before.force_calls);
  CHECK(stepper.statistics().steps == before.steps + 50);
  CHECK(stepper.statistics().sleeping == before.sleeping + 50 * 8);
  CHECK(grains.r == r);
  CHECK(stepper.report().energy_removed > 0);
  // Each fell asleep slower than 1e-3: no more than ½ m v² was taken from each at a time, whatever happened since.
  CHECK(stepper.report().energy_removed < 0.5e-6 * static_cast<double>(stepper.report().fell_asleep) + 1e-6);
}

TEST_CASE("a disc in free flight doesn't fall asleep where it turns") {
  Grains grains{Eigen::Vector2d{0, 10}};
  grains.v.col(0) << 0, 1e-4;
  Sleeping stepper{PhiStepper{grains, scene(), symplectic_euler}, SleepOptions{.speed = 0.05, .steps = 4, .every = 2}};
  for (int n = 0; n < 200; ++n) REQUIRE(stepper.step(grains, dt * n, dt));
  CHECK(stepper.report().fell_asleep == 0);
}

TEST_CASE("a blow wakes the column that it hits, and leaves the other asleep") {
  Grains grains = columns(2);
  grains.add(faller());
  Sleeping stepper{PhiStepper{grains, scene(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  // So long that no sleep ends by itself when the ball is there.
  while ((n < 9000 || stepper.report().asleep < 8) && n < 20000) REQUIRE(stepper.step(grains, dt * n++, dt));
  Grains ball{Eigen::Vector2d{0, 5}};
  ball.v.col(0) << 0, -2;
  grains.add(ball);
  int awake_left = 0, awake_right = 0;
  for (int k = 0; k < 400; ++k) {
    REQUIRE(stepper.step(grains, dt * n++, dt));
    int left = 0, right = 0;
    for (Index i = 0; i < 4; ++i) left += stepper.is_asleep(i) ? 0 : 1, right += stepper.is_asleep(4 + i) ? 0 : 1;
    awake_left = std::max(awake_left, left), awake_right = std::max(awake_right, right);
  }
  CHECK(awake_left == 4);
  CHECK(awake_right == 0);
  // … and all come to rest again where they would have without sleep.
  while (stepper.report().asleep < 9 && n < 60000) REQUIRE(stepper.step(grains, dt * n++, dt));
  CHECK(stepper.report().asleep == 9);
  Grains unskipped = columns(2);
  unskipped.add(ball);
  PhiStepper plain{unskipped, scene(), symplectic_euler};
  for (int k = 0; k < 20000; ++k) REQUIRE(plain.step(unskipped, dt * k, dt));
  grains.erase(8);
  CHECK((unskipped.r - grains.r).cwiseAbs().maxCoeff() < 1e-3);
}

TEST_CASE("a chain of springs at rest sleeps, and all of it wakes in turn when one end is pulled") {
  const auto chain = [](double speed) {
    Grains beads{Eigen::Matrix2Xd(2, 6)};
    for (Index i = 0; i < 6; ++i) beads.r.col(i) << 1.5 * static_cast<double>(i), 0;  // apart: nothing but springs acts
    beads.v.setZero(2, 6);
    std::vector<Spring> springs;
    for (std::ptrdiff_t i = 0; i + 1 < 6; ++i) springs.push_back({i, i + 1, 100, 1.5});
    const auto force = spring_network<2>(springs, SpringDamping{2}) + LinearDrag{0.5};
    Sleeping stepper{PhiStepper{beads, force, symplectic_euler}, SleepOptions{.speed = speed}};
    for (int n = 0; n < 1000; ++n) REQUIRE(stepper.step(beads, dt * n, dt));
    if (speed > 0) CHECK(stepper.report().asleep == 6);
    beads.v(0, 0) = -1;
    for (int n = 1000; n < 3000; ++n) REQUIRE(stepper.step(beads, dt * n, dt));
    if (speed > 0) CHECK(stepper.report().woken >= 6);
    return beads;
  };
  const Grains slept = chain(1e-4), awake = chain(0);
  CHECK(awake.r(0, 5) < 7.4);  // the pull has gone through
  CHECK((slept.r - awake.r).cwiseAbs().maxCoeff() < 1e-3);
}

TEST_CASE(
    "a sleeper that the user moves wakes, one that is erased is gone, one that is held stays, whatever their ids") {
  const bool in_order = GENERATE(true, false);
  Grains grains = columns(3);
  grains.add(faller());
  if (!in_order) grains.set_id({9, 3, 11, 0, 5, 12, 1, 8, 2, 10, 4, 7, 6});
  Sleeping stepper{PhiStepper{grains, scene(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  while (stepper.report().asleep < 12 && n < 20000) REQUIRE(stepper.step(grains, dt * n++, dt));
  grains.v(0, 3) = 0.5;
  REQUIRE(stepper.step(grains, dt * n++, dt));
  CHECK_FALSE(stepper.is_asleep(3));
  CHECK(stepper.is_asleep(11));
  CHECK(grains.v(0, 3) > 0.4);
  grains.erase_if([](Index i) { return i < 4; });
  REQUIRE(stepper.step(grains, dt * n++, dt));
  CHECK(grains.size() == 9);
  CHECK(stepper.report().asleep == 8);
  // The support goes: those above are awake before they could have fallen further than the budget lets them.
  grains.erase(0);
  for (int k = 0; k < 100; ++k) REQUIRE(stepper.step(grains, dt * n++, dt));
  for (Index i = 0; i < 3; ++i) CHECK_FALSE(stepper.is_asleep(i));
  CHECK(stepper.is_asleep(3));
}

namespace {

/// Columns on a floor of discs that are held, all asleep: what is done to them then.
void wakes_all(auto&& act, bool falls = true) {
  Grains grains = columns(2);
  grains.r.row(1).array() += 50;  // far above the floor of Pile
  Grains support{(Eigen::Matrix2Xd(2, 2) << 0, 1.5, 49.51, 49.51).finished()};
  grains.add(support);
  grains.set_still({0, 0, 0, 0, 0, 0, 0, 0, 1, 1});
  Sleeping stepper{PhiStepper{grains, scene(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  while (stepper.report().asleep < 8 && n < 20000) REQUIRE(stepper.step(grains, dt * n++, dt));
  REQUIRE(stepper.report().asleep == 8);
  for (int k = 0; k < 10; ++k) REQUIRE(stepper.step(grains, dt * n++, dt));
  act(grains, stepper);
  REQUIRE(stepper.step(grains, dt * n++, dt));
  CHECK(stepper.report().asleep == 0);
  if (!falls) return;
  const Eigen::Matrix2Xd before = grains.r.leftCols(8);
  for (int k = 0; k < 200; ++k) REQUIRE(stepper.step(grains, dt * n++, dt));
  for (Index i = 0; i < 8; ++i) CHECK((grains.r.col(i) - before.col(i)).norm() > 0.05);
}

}  // namespace

TEST_CASE("where everything sleeps, whatever is changed wakes all") {
  wakes_all([](Grains& y, auto&) { y.r.rightCols(2).row(1).array() -= 5; });        // the support, which is held
  wakes_all([](Grains& y, auto&) { y.erase_if([](Index i) { return i >= 8; }); });  // … goes
  wakes_all([](Grains& y, auto&) { y.set_still({0, 0, 0, 0, 0, 0, 0, 0, 0, 0}); });
  wakes_all([](Grains&, auto& stepper) { std::get<1>(stepper.stepper().force().terms).g *= -1; });
  wakes_all([](Grains& y, auto&) { y.v.col(8) << 0, -20; }, false);
  wakes_all([](Grains&, auto& stepper) { stepper.reset(); }, false);
  wakes_all([](Grains&, auto& stepper) { stepper.stepper().reset(); }, false);
  wakes_all([](Grains& y, auto&) { y.set_mass(2.0); }, false);
  wakes_all([](Grains& y, auto&) { y.r(0, 3) += 1e-9; }, false);
  wakes_all([](Grains& y, auto&) { y.add(Grains{Eigen::Vector2d{20, 90}}); }, false);
}
TEST_CASE("where everything sleeps and nothing is changed, nothing wakes, not after a checkpoint either") {
  Grains grains = columns(2);
  Sleeping stepper{PhiStepper{grains, scene(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  while (stepper.report().asleep < 8 && n < 20000) REQUIRE(stepper.step(grains, dt * n++, dt));
  for (int k = 0; k < 10; ++k) REQUIRE(stepper.step(grains, dt * n++, dt));
  Writer out;
  out.save(stepper, grains);
  const auto twin = [&](auto&& edit) {
    Grains again = columns(2);
    Sleeping other{PhiStepper{again, scene(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
    other.stepper().reset();  // before, and not of interest after
    Reader in{out.bytes()};
    in.load(other, again);
    edit(again);
    REQUIRE(other.step(again, dt * n, dt));
    return other.report().asleep;
  };
  CHECK(twin([](Grains&) {}) == 8);
  CHECK(twin([](Grains& y) { y.set_mass(2.0); }) == 0);
  CHECK(twin([](Grains& y) { y.r(1, 2) += 1e-9; }) == 0);
  REQUIRE(stepper.step(grains, dt * n, dt));
  CHECK(stepper.report().asleep == 8);
}
TEST_CASE("a support that goes while somebody else is awake wakes what lay on it") {
  Grains grains = columns(1);
  grains.r.row(1).array() += 50;
  grains.add(Grains{(Eigen::Matrix2Xd(2, 2) << 0, 20, 49.51, 1e6).finished()});  // the support, and one that falls
  grains.set_still({0, 0, 0, 0, 1, 0});
  Sleeping stepper{PhiStepper{grains, scene(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  while (stepper.report().asleep < 4 && n < 20000) REQUIRE(stepper.step(grains, dt * n++, dt));
  for (int k = 0; k < 2000; ++k) REQUIRE(stepper.step(grains, dt * n++, dt));
  grains.r(1, 4) -= 5;
  const double before = grains.r(1, 0);
  for (int k = 0; k < 200; ++k) REQUIRE(stepper.step(grains, dt * n++, dt));
  CHECK(grains.r(1, 0) < before - 0.05);
}

TEST_CASE("with speed 0 nothing differs from the stepper inside") {
  Grains a = columns(2), b = a;
  Sleeping stepper{PhiStepper{a, scene(), symplectic_euler}, SleepOptions{}};
  PhiStepper plain{b, scene(), symplectic_euler};
  for (int n = 0; n < 500; ++n) {
    REQUIRE(stepper.step(a, dt * n, dt));
    REQUIRE(plain.step(b, dt * n, dt));
  }
  CHECK(a.r == b.r);
  CHECK(a.v == b.v);
  CHECK(stepper.statistics() == plain.statistics());
}

TEST_CASE("a checkpoint in the middle of sleep goes on with the same bits") {
  const auto run = [](Grains& grains, auto& stepper, int from, int to) {
    for (int n = from; n < to; ++n) REQUIRE(stepper.step(grains, dt * n, dt));
  };
  const SleepOptions options{.speed = 2e-3, .steps = 40, .every = 10};
  Grains grains = columns(3);
  grains.add(Grains{Eigen::Vector2d{1.5, 160}});
  Sleeping stepper{PhiStepper{grains, scene(), symplectic_euler}, options};
  run(grains, stepper, 0, 5200);
  REQUIRE(stepper.report().asleep > 0);
  Writer out;
  out.save(stepper, grains);
  run(grains, stepper, 5200, 6200);

  Grains again = columns(3);
  again.add(Grains{Eigen::Vector2d{1.5, 160}});
  Sleeping other{PhiStepper{again, scene(), symplectic_euler}, options};
  Reader in{out.bytes()};
  in.load(other, again);
  run(again, other, 5200, 6200);
  CHECK(again.r == grains.r);
  CHECK(again.v == grains.v);
  CHECK(other.report().skipped == stepper.report().skipped);
}

namespace {
using Balls = Particles<double, 3, Spin>;
const Hooke law{.stiffness = 1e4, .restitution = 0.3, .friction = 0.6, .rolling_friction = 0.2};
auto on_floor() {
  return Contact{law} + Walls<Hooke>{law, Plane<3>{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()}} +
         Gravity{Eigen::Vector3d{0, 0, -9.81}};
}
/// In heaps of five, and one beyond them that falls for long.
Balls heaps(int count) {
  Balls balls{Eigen::Matrix3Xd(3, 5 * count + 1)};
  for (int h = 0; h < count; ++h)
    for (int k = 0; k < 5; ++k)
      balls.r.col(5 * h + k) << 3 * h + (k < 4 ? k % 2 : 0.5), k < 4 ? k / 2 : 0.5, k < 4 ? 0.4999 : 1.2;
  balls.r.col(5 * count) << 0, 50, 1e6;
  balls.set_mass(1.0).set_radius(0.5);
  return balls;
}
}  // namespace

TEST_CASE("a ball that spins on the spot sleeps, keeps its spin, and goes on with it") {
  Balls balls = heaps(1);
  balls.add(Balls{Eigen::Vector3d{20, 0, 0.4999}}.set_radius(0.5));
  balls.omega.col(6) << 0, 0, 3;  // about the normal of its contact: no friction
  Sleeping stepper{PhiStepper{balls, on_floor(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  for (; n < 20000 && stepper.report().asleep < 6; ++n) REQUIRE(stepper.step(balls, dt / 5 * n, dt / 5));
  REQUIRE(stepper.is_asleep(6));
  CHECK(balls.omega.col(6) == Eigen::Vector3d{0, 0, 3});
  CHECK(balls.v.col(6) == Eigen::Vector3d::Zero());
  CHECK(stepper.report().energy_removed < 1e-5);  // its rotation, 0.45, is none that was removed
  balls.v(0, 6) = 0.1;
  REQUIRE(stepper.step(balls, dt / 5 * n, dt / 5));
  CHECK_FALSE(stepper.is_asleep(6));
  CHECK_THAT(balls.omega(2, 6), Catch::Matchers::WithinRel(3.0, 1e-6));
  // One that friction slows is awake.
  Balls rolling{Eigen::Vector3d{0, 0, 0.4999}};
  rolling.set_radius(0.5).omega.col(0) << 3, 0, 0;
  Sleeping other{PhiStepper{rolling, on_floor(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  for (n = 0; n < 2000; ++n) REQUIRE(other.step(rolling, dt / 5 * n, dt / 5));
  CHECK(other.report().fell_asleep == 0);
}

TEST_CASE("a step of sleepers beside some that are awake computes their pairs and no others") {
  Balls balls = heaps(10);
  Sleeping stepper{PhiStepper{balls, on_floor(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  for (; n < 40000 && stepper.report().asleep < 50; ++n) REQUIRE(stepper.step(balls, dt / 5 * n, dt / 5));
  REQUIRE(stepper.report().asleep == 50);
  const auto& counts = std::get<0>(stepper.stepper().force_to_look_at().terms).statistics();
  const std::int64_t rebuilds = counts.rebuilds;
  REQUIRE(stepper.step(balls, dt / 5 * n++, dt / 5));
  CHECK(counts.pairs == 0);
  balls.v(2, 14) = 0.1;  // the top of a heap: it and the four that it touches
  REQUIRE(stepper.step(balls, dt / 5 * n++, dt / 5));
  CHECK(counts.pairs == 8);
  CHECK(stepper.report().asleep == 45);
  balls.v(0, 50) = 0.1;  // of one that is awake, an edit wakes nobody
  for (const int end = n + 20; n < end; ++n) REQUIRE(stepper.step(balls, dt / 5 * n, dt / 5));
  CHECK(counts.pairs == 8);
  CHECK(stepper.report().asleep == 45);
  CHECK(counts.rebuilds == rebuilds);
  CHECK(stepper.statistics().force_calls == stepper.statistics().steps);
}

TEST_CASE("balls asleep on balls, from a checkpoint: the same bits, springs and report included") {
  const auto run = [](Balls& balls, auto& stepper, int from, int to) {
    for (int n = from; n < to; ++n) {
      if (n % 700 == 0) balls.v(0, 5 * (n / 700 % 6) + 4) += 0.02;
      REQUIRE(stepper.step(balls, dt / 5 * n, dt / 5));
    }
  };
  const SleepOptions options{.speed = 2e-3, .steps = 40, .every = 10};
  const auto make = [&](Balls& balls) { return Sleeping{PhiStepper{balls, on_floor(), symplectic_euler}, options}; };
  Balls balls = heaps(6);
  auto stepper = make(balls);
  for (const int at : {4350, 4911, 5603}) {
    run(balls, stepper, at == 4350 ? 0 : at == 4911 ? 4350 : 4911, at);
    REQUIRE(stepper.report().asleep > 3);
    REQUIRE(stepper.report().asleep < 31);
    Writer out;
    out.save(stepper, balls);
    Balls again = heaps(6), on = balls;
    auto other = make(again);
    Reader in{out.bytes()};
    in.load(other, again);
    auto same = stepper;
    run(on, same, at, at + 2500);
    run(again, other, at, at + 2500);
    CHECK(again.r == on.r);
    CHECK(again.v == on.v);
    CHECK(again.omega == on.omega);
    CHECK(same.report().woken > stepper.report().woken);
    CHECK(other.report().skipped == same.report().skipped);
    CHECK(other.report().impulse_not_applied == same.report().impulse_not_applied);
  }
}

TEST_CASE("the comparison prints both runs of a scene") {
  std::ostringstream out;
  const auto drop = [](SleepOptions options) {
    Grains grains = columns(1);
    Sleeping stepper{PhiStepper{grains, scene(), symplectic_euler}, options};
    for (int n = 0; n < 3000; ++n) REQUIRE(stepper.step(grains, dt * n, dt));
    return grains;
  };
  compare_sleep(out, {.speed = 1e-3}, drop, std::pair{"height", [](const Grains& y) { return y.r.row(1).maxCoeff(); }});
  CHECK(out.str().find("height: 3.") != std::string::npos);
  CHECK(out.str().find("difference") != std::string::npos);
}

namespace {
/// One disc on a spring.
struct Shaker : ForceTerm {
  Index who;
  Eigen::Vector2d about;
  Shaker(Index disc, Eigen::Vector2d place) : who{disc}, about{std::move(place)} {}
  static constexpr bool uses_velocity = false, uses_time = false, acts_on_each = true;
  void add(auto, const auto& y, auto& out) const { out.force.col(who) -= 100 * (y.r.col(who) - about); }
};
}  // namespace

TEST_CASE("another force whose list is as often made: who touches one that is awake is found by its pairs") {
  Grains discs{Eigen::Matrix2Xd{{0, 10, 50}, {0, 0, 0}}};
  discs.set_radius(0.5).set_mass(Eigen::Vector3d{1e9, 1, 1});
  discs.v(1, 2) = 0.5;
  const auto force = [](Index who, const Eigen::Vector2d& about) {
    return Contact{Hooke{.stiffness = 100}} + Shaker{who, about};
  };
  Sleeping stepper{PhiStepper{discs, force(2, {50, 0}), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  int n = 0;
  while (stepper.report().asleep < 2 && n < 2000) REQUIRE(stepper.step(discs, dt * n++, dt));
  REQUIRE(stepper.report().asleep == 2);
  stepper.stepper().force() = force(1, {0.99, 0});
  discs.r(0, 1) = 0.99;
  discs.v.setZero();
  discs.v(1, 1) = 0.5;
  for (int k = 0; k < 500; ++k) REQUIRE(stepper.step(discs, dt * n++, dt));
  CHECK_FALSE(stepper.is_asleep(0));
  CHECK(stepper.is_asleep(2));
}

TEST_CASE("options that can't work are refused") {
  Grains grains = columns(1);
  CHECK_THROWS_AS((Sleeping{PhiStepper{grains, scene(), symplectic_euler}, SleepOptions{.speed = -1}}),
                  std::invalid_argument);
  CHECK_THROWS_AS((Sleeping{PhiStepper{grains, scene(), symplectic_euler}, SleepOptions{.speed = 1, .every = 0}}),
                  std::invalid_argument);
}
