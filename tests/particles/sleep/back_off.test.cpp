// Nobody sleeps where too few would, or where changes of who sleeps cost more than sleep saves: exact counts of who sleeps,
// of the sets that the force is shown, of when all are woken and when they are let sleep again. And nobody sleeps through a
// push that goes on.
#include <phistep/particles.hpp>
#include <phistep/particles/sleep/sleeping.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Points = Particles<double, 2>;

namespace {

constexpr double dt = 1e-3;
constexpr SleepOptions options{.speed = 1e-2, .steps = 20, .every = 10};

/// No force; notes the number of the active set at each call, 0 where all are computed.
struct Watch : ForceTerm {
  std::vector<std::uint64_t>* seen;
  explicit Watch(std::vector<std::uint64_t>& sets) : seen{&sets} {}
  static constexpr bool uses_velocity = false, uses_time = false, acts_on_each = true, computes_active_only = true;
  void add(auto, const auto& y, auto&) const { seen->push_back(number_of(active_set(y))); }
};

/// 100 points, of which the first lie still and the others fly on.
struct Scene {
  Points points{Eigen::Matrix2Xd(2, 100)};
  std::vector<std::uint64_t> sets;
  Sleeping<PhiStepper<Points, Watch, std::remove_const_t<decltype(symplectic_euler)>>> stepper;
  int done = 0;

  explicit Scene(int at_rest) : stepper{PhiStepper{start(points, at_rest), Watch{sets}, symplectic_euler}, options} {}
  Scene(const Scene&) = delete;
  /// Up to so many steps from the beginning. @param before  called before each
  void run_to(int end, auto&& before) {
    for (; done < end; ++done) {
      before();
      REQUIRE(stepper.step(points, dt * done, dt));
    }
    REQUIRE(sets.size() == static_cast<std::size_t>(done));
  }
  void run_to(int end) {
    run_to(end, [] {});
  }
  [[nodiscard]] std::int64_t asleep() const { return stepper.report().asleep; }
  /// Sets that were shown after `from` and up to the step `to`.
  [[nodiscard]] std::size_t sets_of(int from, int to) const {
    const std::set<std::uint64_t> distinct(sets.begin() + from, sets.begin() + to);
    return distinct.size() - distinct.count(0);
  }
  [[nodiscard]] auto all_computed(int from, int to) const {
    return std::all_of(sets.begin() + from, sets.begin() + to, [](std::uint64_t number) { return number == 0; });
  }

 private:
  static Points& start(Points& points, int at_rest) {
    for (Index i = 0; i < 100; ++i) points.r.col(i) << 10.0 * static_cast<double>(i), 0;
    points.v.setZero(2, 100);
    points.v.row(1).tail(100 - at_rest).setOnes();
    return points;
  }
};

/// Pushes the first ten along x from t = 1 on, for 0.1; counts the calls for all.
struct Drive : ForceTerm {
  int* looks;
  static constexpr bool uses_velocity = false, acts_on_each = true;
  void add(double t, const auto& y, auto& out) const {
    *looks += active_set(y) == nullptr;
    if (t >= 1 && t < 1.1) out.force.row(0).head(10).array() += 1;
  }
};

}  // namespace

TEST_CASE("a set that changes at every step is given up, and tried again when that is forgotten") {
  Scene scene{36};
  scene.run_to(19);
  CHECK(scene.asleep() == 0);
  scene.run_to(20);  // the second check: 20 quiet steps
  CHECK(scene.asleep() == 36);
  scene.run_to(30);
  CHECK(scene.sets_of(20, 30) == 1);
  Index next = 0;
  const auto move_another = [&] { scene.points.r(0, next++) += 1e-9; };
  scene.run_to(39, move_another);
  CHECK(scene.asleep() == 27);
  scene.run_to(40, move_another);  // ten sets in ten steps: 0.4 of all would have to sleep, 26 do
  CHECK(scene.asleep() == 0);
  CHECK(scene.stepper.report().woken == 36);
  CHECK(scene.sets_of(30, 40) == 10);
  // 100 (0.1 + 0.45·0.97^k) <= 36 for k = 19 checks.
  scene.run_to(229);
  CHECK(scene.asleep() == 0);
  scene.run_to(230);
  CHECK(scene.all_computed(40, 230));
  CHECK(scene.asleep() == 36);
  scene.run_to(700);
  CHECK(scene.sets_of(230, 700) == 1);
  CHECK(scene.stepper.report().fell_asleep == 72);
  CHECK(scene.stepper.report().woken == 36);
  CHECK(scene.stepper.report().skipped == 10 * 36 + (35 + 26) * 10 / 2 + 470 * 36);
}

TEST_CASE("a set that changes at every step is kept where most sleep in spite of that") {
  Scene scene{90};
  scene.run_to(30);
  CHECK(scene.asleep() == 90);
  Index next = 0;
  std::int64_t fewest = 90;
  scene.run_to(600, [&] {
    scene.points.r(0, next++ % 90) += 1e-9;
    fewest = std::min(fewest, scene.asleep());
  });
  // Ten are woken between two checks, and sleep again at the second check.
  CHECK(fewest == 90 - 19);
  CHECK(scene.sets_of(30, 600) == 570);
  CHECK_FALSE(scene.all_computed(30, 31));
  CHECK(scene.stepper.report().woken == 570);
}

TEST_CASE("a change now and then keeps nobody awake") {
  Scene scene{36};
  scene.run_to(30);
  Index next = 0;
  scene.run_to(1030, [&] {
    if (scene.done % 10 == 0) scene.points.r(0, next++ % 36) += 1e-9;
  });
  CHECK(scene.stepper.report().woken == 100);
  CHECK(scene.stepper.report().fell_asleep == 36 + 99);
}

TEST_CASE("too few aren't put to sleep") {
  // Setting out is a change, too: 0.1 sets a step, 0.097 at the second check.
  Scene enough{13};
  enough.run_to(20);
  CHECK(enough.asleep() == 13);
  // Twelve are enough when the unrest, 0.1 at the step 30, is 0.0653: 14 checks later.
  Scene few{12};
  few.run_to(169);
  CHECK(few.asleep() == 0);
  few.run_to(170);
  CHECK(few.asleep() == 12);
  Scene fewer{10};
  fewer.run_to(3000);
  CHECK(fewer.all_computed(0, 3000));
  CHECK(fewer.stepper.report().fell_asleep == 0);
}

TEST_CASE("a term that changes with time by itself wakes those that it pushes otherwise") {
  int looks = 0;
  for (const int of : {100, 10}) {  // beside others, and alone
    Points y{Eigen::Matrix2Xd(2, of)};
    for (Index i = 0; i < of; ++i) y.r.col(i) << 10.0 * static_cast<double>(i), 0;
    Sleeping stepper{PhiStepper{y, Drive{{}, &looks}, symplectic_euler}, options};
    int n = 0;
    const auto run_to = [&](int end) {
      for (; n < end; ++n) REQUIRE(stepper.step(y, dt * n, dt));
    };
    run_to(990);
    CHECK(stepper.report().asleep == of);
    CHECK(stepper.report().woken == 0);
    looks = 0;
    run_to(1000);
    CHECK(looks == 1);
    run_to(1300);
    CHECK(stepper.report().woken == 10);
    CHECK(stepper.report().asleep == of - 10);
    CHECK(y.v.row(0).head(10).minCoeff() >= 0.1 - options.every * dt - 1e-12);
    CHECK(y.v.row(0).head(10).maxCoeff() <= 0.1 + 1e-12);
  }
}

TEST_CASE("who came later doesn't sleep through a push any longer than who was there from the start") {
  constexpr SleepOptions often{.speed = 1e-3, .steps = 20, .every = 5};
  Points points{Eigen::Matrix2Xd::Zero(2, 1)};
  points.set_still({1});
  Sleeping stepper{PhiStepper{points, Gravity{Eigen::Vector2d{1e-4, 0}}, symplectic_euler}, often};
  int done = 0;
  const auto run = [&](int steps) {
    for (const int end = done + steps; done < end; ++done) REQUIRE(stepper.step(points, 0.01 * done, 0.01));
  };
  run(10'000);
  points.add(Points{Eigen::Matrix2Xd::Constant(2, 1, 5)}.set_still({0}));
  run(20'000);
  CHECK(stepper.report().fell_asleep > 0);
  CHECK(std::abs(points.v(0, 1) - 0.02) < 1e-5);
}

TEST_CASE("a grain that rolls down a gentle slope doesn't stop for having slept") {
  using Grain = Particles<double, 3, Spin>;
  for (const double angle : {0.001, 0.002, 0.01})
    for (const double speed : {1e-3, 3e-3, 1e-2}) {
      CAPTURE(angle, speed);
      Grain grain{Eigen::Matrix3Xd(Eigen::Vector3d{0, 0, 0.00499})};
      grain.set_mass(1e-3).set_radius(0.005);
      const Walls floor{Hooke{.stiffness = 1e3, .restitution = 0.3, .friction = 0.4},
                        Plane<3>{.point = {0, 0, 0}, .normal = {0, 0, 1}}};
      const Gravity weight{Eigen::Vector3d{9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)}};
      Sleeping stepper{PhiStepper{grain, weight + floor, symplectic_euler}, SleepOptions{.speed = speed}};
      REQUIRE(integrate(stepper, grain, {0.0, 3.0}, fixed(1e-4)));
      const double v = 5.0 / 7 * 9.81 * std::sin(angle) * 3;  // without slipping, a solid sphere
      CHECK(std::abs(grain.v(0, 0) - v) < speed + 0.002 * v);
      CHECK(std::abs(grain.r(0, 0) - 1.5 * v) < 3 * speed + 0.002 * v);
    }
}
