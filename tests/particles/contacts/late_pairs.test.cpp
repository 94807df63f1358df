// Few bodies that have moved far have their pairs found alone: none is missed, springs stay, waking goes by them, too.
#include <phistep/particles.hpp>
#include <phistep/particles/sleep/sleeping.hpp>

#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Grains = Particles<double, 3, Spin>;
using Eigen::Vector3d;
using Pair = std::pair<Index, Index>;

namespace {

constexpr double dt = 1e-3;
const Hooke law{.stiffness = 1e4, .restitution = 0.5, .friction = 0.5, .rolling_friction = 0.1};

/// Clusters of touching grains, and a few fast ones among them.
Grains clusters(int n, double size, bool periodic, std::mt19937& random) {
  std::uniform_real_distribution<double> u(0, 1);
  Grains grains{Eigen::Matrix3Xd(3, n)};
  Eigen::VectorXd radius(n);
  for (Index i = 0; i < n; ++i) {
    for (double& x : grains.r.col(i)) x = size * u(random);
    if (i % 4 != 0)
      grains.r.col(i) = grains.r.col(i - 1) + 0.95 * Vector3d{u(random), u(random), u(random)}.normalized();
    radius[i] = 0.4 + 0.2 * u(random);
    grains.v.col(i) = Vector3d{u(random), u(random), u(random)} - Vector3d::Constant(0.5);
    if (i % 20 == 7) grains.v.col(i) *= 40;
    grains.omega.col(i) = grains.v.col(i).reverse();
  }
  grains.set_mass(1.0).set_radius(radius);
  auto box = Box<double, 3>::periodic(Vector3d::Zero(), Vector3d::Constant(size));
  for (auto& axis : box.is_periodic) axis = periodic;
  grains.set_box(box);
  return grains;
}
std::set<Pair> listed(auto& stepper) {
  std::set<Pair> all;
  std::size_t count = 0;
  stepper.force_to_look_at().for_each_pair(stepper.memory(), [&](Index i, Index j) {
    all.insert(std::minmax(i, j));
    ++count;
  });
  REQUIRE(all.size() == count);  // each once
  return all;
}
/// Every two that touch are listed.
void check_all(const Grains& y, const std::set<Pair>& list) {
  for (Index j = 1; j < y.size(); ++j)
    for (Index i = 0; i < j; ++i)
      if (y.box().nearest(y.r.col(i) - y.r.col(j)).norm() < y.radius()[i] + y.radius()[j])
        REQUIRE(list.contains({i, j}));
}

}  // namespace

TEST_CASE("fast grains among others, whoever is left out: no contact is missed, and springs are those of lists anew") {
  for (const bool periodic : {false, true}) {
    std::mt19937 random(periodic ? 3 : 4);
    Grains a = clusters(280, 11, periodic, random), b = a;
    // Of b all pairs are found at every step: its skin is that thin, and many move.
    PhiStepper one{a, Contact{law}, symplectic_euler}, other{b, Contact{law, 1e-7}, symplectic_euler};
    std::vector<std::uint8_t> flags(280, 1);
    std::int64_t touching = 0;
    for (int n = 0; n < 300; ++n) {
      if (n % 10 == 0) {
        // Those left out stay, or fly on.
        for (std::size_t i = 0; i < flags.size(); ++i) {
          flags[i] = random() % 4 != 0 || i % 20 == 7;
          if (flags[i] == 0 && i % 3 != 0) a.v.col(static_cast<Index>(i)).setZero();
          b.v.col(static_cast<Index>(i)) = a.v.col(static_cast<Index>(i));
        }
        auto set = std::make_shared<ActiveSet>();
        set->assign(flags, next_serial());
        one.set_active(set), other.set_active(set);
      }
      REQUIRE(one.step(a, dt * n, dt));
      REQUIRE(other.step(b, dt * n, dt));
      touching += one.force_to_look_at().statistics().touching;
      REQUIRE(one.force_to_look_at().statistics().touching == other.force_to_look_at().statistics().touching);
      if (n % 8 == 7) check_all(a, listed(one));
      REQUIRE((a.r - b.r).cwiseAbs().maxCoeff() < 1e-9);
      REQUIRE((a.omega - b.omega).cwiseAbs().maxCoeff() < 1e-6);
    }
    CHECK(touching > 5000);
    CHECK(one.force_to_look_at().statistics().late > 30);
    CHECK(one.force_to_look_at().statistics().rebuilds < 60);
    CHECK(other.force_to_look_at().statistics().rebuilds == 300);
    // All are computed again: by a list of all.
    one.set_active(nullptr), other.set_active(nullptr);
    REQUIRE(one.step(a, dt * 300, dt));
    REQUIRE(other.step(b, dt * 300, dt));
    CHECK(one.force_to_look_at().statistics().touching == other.force_to_look_at().statistics().touching);
    CHECK((a.v - b.v).cwiseAbs().maxCoeff() < 1e-6);
  }
}

namespace {
/// A carpet of grains, one that stands out of it, and the last one, which flies over it, too high to touch, towards that.
Grains carpet() {
  constexpr Index side = 12, n = side * side;
  Grains grains{Eigen::Matrix3Xd(3, n + 2)};
  for (Index i = 0; i < n; ++i) grains.r.col(i) << static_cast<double>(i % side), static_cast<double>(i / side), 0.5;
  grains.r.col(n) << 10, 5, 1.5;
  grains.r.col(n + 1) << -2, 5, 1.6;
  grains.v.col(n + 1) << 20, 0, 0;
  grains.set_mass(1.0).set_radius(0.5);
  return grains;
}
auto asleep_from(const Grains& grains) {
  return Sleeping{PhiStepper{grains, Contact{law}, symplectic_euler},
                  SleepOptions{.speed = 1e-2, .steps = 5, .every = 5}};
}
}  // namespace

TEST_CASE(
    "a fast grain over sleepers makes no list of all, and wakes whom it hits; a checkpoint in its flight has the "
    "bits") {
  Grains grains = carpet();
  const Index post = grains.size() - 2;
  auto stepper = asleep_from(grains);
  const auto run = [](auto& with, Grains& y, int from, int to) {
    for (int n = from; n < to; ++n) REQUIRE(with.step(y, dt * n, dt));
  };
  run(stepper, grains, 0, 400);  // at x = 6
  const auto& statistics = stepper.force_to_look_at().statistics();
  CHECK(stepper.report().asleep == grains.size() - 1);
  CHECK(stepper.report().woken == 0);
  CHECK(statistics.rebuilds == 1);
  CHECK(statistics.late > 20);
  Writer out;
  out.save(stepper, grains);
  run(stepper, grains, 400, 700);
  CHECK(grains.v.col(post).norm() > 5);
  CHECK(!stepper.is_asleep(post));
  CHECK(stepper.report().woken > 0);
  CHECK(statistics.rebuilds == 1);
  check_all(grains, listed(stepper));

  Grains again = carpet();
  auto other = asleep_from(again);
  Reader in{out.bytes()};
  in.load(other, again);
  run(other, again, 400, 700);
  CHECK(again.r == grains.r);
  CHECK(again.v == grains.v);
  CHECK(again.omega == grains.omega);
  CHECK(other.report().skipped == stepper.report().skipped);
}

TEST_CASE("two fast grains that meet over sleepers, and fly on while they touch, keep their springs") {
  Grains one{Eigen::Matrix3Xd(3, 1)};
  one.r.col(0) << -2.1, 6.4, 1.6;
  one.v.col(0) << 20.6, -2, 0;
  one.set_mass(1.0).set_radius(0.5);
  Grains a = carpet();
  a.add(one);
  Grains b = a;
  auto sleeping = asleep_from(a);
  PhiStepper awake{b, Contact{law}, symplectic_euler};
  for (int n = 0; n < 300; ++n) {
    REQUIRE(sleeping.step(a, dt * n, dt));
    REQUIRE(awake.step(b, dt * n, dt));
  }
  CHECK(sleeping.report().asleep == a.size() - 2);
  CHECK(sleeping.force_to_look_at().statistics().rebuilds == 1);
  CHECK(awake.force_to_look_at().statistics().rebuilds > 20);
  CHECK(b.omega.col(b.size() - 1).norm() > 0.1);  // they rubbed
  CHECK((a.r - b.r).cwiseAbs().maxCoeff() < 1e-9);
  CHECK((a.omega - b.omega).cwiseAbs().maxCoeff() < 1e-7);
}

TEST_CASE("late pairs come back from a checkpoint, and none that can't be") {
  const auto copied = [](const ContactPlaces<double>& from) {
    Writer out;
    out(from);
    ContactPlaces<double> to;
    Reader in{out.bytes()};
    in(to);
    return to;
  };
  Grains grains = carpet();
  ContactPairs<double> pairs;
  ContactSearch<double, 3>{}.find(grains.r, grains.body(), 0.3, pairs);
  const auto count = static_cast<std::int32_t>(pairs.places());
  const ContactPlaces<double> good{std::make_shared<const ContactPairs<double>>(pairs),
                                   {{3, {1, 2, 3}}, {9, {4, 5, 6}}},
                                   {{count + 1, 0, 70}, {count + 5, 3, 9}},
                                   count + 6};
  const auto again = copied(good);
  CHECK(again.has(count + 5));
  CHECK(again.has(count - 1));
  CHECK(!again.has(count + 2));
  CHECK(again.slots(count + 1) == std::array{0, 70});
  CHECK(again.stray(9)->at[1] == 5);
  const auto refused = [&](auto&& spoil) {
    auto bad = good;
    spoil(bad);
    CHECK_THROWS_AS(copied(bad), CheckpointError);
  };
  refused([](auto& places) { places.strays[1].at[2] = std::nan(""); });
  refused([](auto& places) { places.strays[1].slot = 3; });
  refused([](auto& places) { places.strays[1].slot = 4000; });
  refused([](auto& places) { places.strays[0].slot = -1; });
  refused([](auto& places) { places.late[0].second = 4000; });
  refused([](auto& places) { places.late[0].first = 70; });
  refused([](auto& places) { places.late[0].first = -1; });
  refused([&](auto& places) { places.late[0].place = count - 1; });
  refused([&](auto& places) { places.late[1].place = count + 1; });
  refused([&](auto& places) { places.next = count + 5; });
}
