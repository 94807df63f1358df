// Who is left out of the active set costs no pair, no list and no search, and stays as it is.
#include <phistep/particles.hpp>
#include <phistep/particles/sleep/sleeping.hpp>

#include <map>
#include <memory>
#include <random>
#include <tuple>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;
using Grains = Particles<double, 3, Spin>;
using Eigen::Vector3d;

namespace {

constexpr double dt = 2e-4;
const Hooke law{.stiffness = 1e4, .restitution = 0.3, .friction = 0.6, .rolling_friction = 0.2};
auto on_floor() {
  return Contact{law} + Walls<Hooke>{law, Plane<3>{Vector3d::Zero(), Vector3d::UnitZ()}} +
         Gravity{Vector3d{0, 0, -9.81}};
}
/// side² grains side by side on the floor and as many on top of them, all touching.
Grains carpet(int side) {
  Grains grains{Eigen::Matrix3Xd(3, 2 * side * side)};
  Index n = 0;
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x, ++n) grains.r.col(n) << 0.999 * x, 0.999 * y, 0.4995 + 0.999 * z;
  grains.set_mass(1.0).set_radius(0.5);
  return grains;
}
std::shared_ptr<const ActiveSet> set_of(const std::vector<std::uint8_t>& flags, std::uint64_t number) {
  auto set = std::make_shared<ActiveSet>();
  set->assign(flags, number);
  return set;
}
const ContactStatistics& contacts_of(auto& stepper) {
  return std::get<0>(stepper.force_to_look_at().terms).statistics();
}

}  // namespace

TEST_CASE("a set of everybody, another one at each step: the bits of none") {
  Grains a = carpet(3), b = a;
  a.v.setRandom(), b.v = a.v;
  PhiStepper one{a, on_floor(), symplectic_euler}, other{b, on_floor(), symplectic_euler};
  for (int n = 0; n < 400; ++n) {
    if (n % 3 != 2) one.set_active(set_of(std::vector<std::uint8_t>(18, 1), 1000 + static_cast<std::uint64_t>(n)));
    else one.set_active(nullptr);
    REQUIRE(one.step(a, dt * n, dt));
    REQUIRE(other.step(b, dt * n, dt));
  }
  CHECK(a.r == b.r);
  CHECK(a.v == b.v);
  CHECK(a.omega == b.omega);
  CHECK(one.statistics() == other.statistics());
}

TEST_CASE("who is left out stays, pushes the others, and costs no pair; the list and the springs are those of all") {
  Grains grains = carpet(4);
  grains.v.row(0).setConstant(1e-3);  // so that friction springs are stretched
  PhiStepper stepper{grains, on_floor(), symplectic_euler};
  for (int n = 0; n < 50; ++n) REQUIRE(stepper.step(grains, dt * n, dt));
  const std::int64_t all = contacts_of(stepper).pairs, rebuilds = contacts_of(stepper).rebuilds;
  const std::uint64_t serial = grains.body().serial;
  REQUIRE(rebuilds == 1);
  // Left out: the half x < 2.
  std::vector<std::uint8_t> flags(32);
  std::int64_t among = 0;
  const auto is_out = [&](Index i) { return i % 4 < 2; };
  for (Index i = 0; i < 32; ++i) flags[static_cast<std::size_t>(i)] = is_out(i) ? 0 : 1;
  std::get<0>(stepper.force_to_look_at().terms).for_each_pair(std::get<0>(stepper.memory()), [&](Index i, Index j) {
    among += is_out(i) && is_out(j);
  });
  REQUIRE(among > 20);

  for (Index i = 0; i < 32; ++i)
    if (is_out(i)) grains.v.col(i).setZero(), grains.omega.col(i).setZero();
  const Grains before = grains;
  const auto springs = std::get<0>(stepper.memory()).springs;
  stepper.set_active(set_of(flags, 7));
  REQUIRE(stepper.step(grains, dt * 50, dt));
  CHECK(contacts_of(stepper).pairs == all - among);
  CHECK(contacts_of(stepper).rebuilds == rebuilds);
  CHECK(grains.body().serial == serial);
  for (Index i = 0; i < 32; ++i)
    if (is_out(i)) {
      CHECK(grains.r.col(i) == before.r.col(i));
      CHECK(grains.v.col(i) == before.v.col(i));
    } else {
      CHECK(grains.r.col(i) != before.r.col(i));
    }
  // Their springs wait, none is lost.
  const auto& remembered = std::get<0>(stepper.memory());
  REQUIRE(remembered.resting != nullptr);
  const auto& resting = *remembered.resting->base;
  CHECK(resting.size() > 10);
  CHECK(resting.size() + remembered.springs->size() == springs->size());
  for (std::size_t c = 0, old = 0; c < resting.size(); ++c, ++old) {
    while (springs->place[old] != resting.place[c]) ++old;
    CHECK(springs->numbers[0][old] == resting.numbers[0][c]);
    CHECK(springs->numbers[4][old] == resting.numbers[4][c]);
  }
  stepper.set_active(nullptr);
  REQUIRE(stepper.step(grains, dt * 51, dt));
  CHECK(std::get<0>(stepper.memory()).resting == nullptr);
  CHECK(contacts_of(stepper).pairs == all);
  CHECK(contacts_of(stepper).rebuilds == rebuilds);
}

namespace {
/// ξ of every contact, computed or not, by its place.
std::map<std::int32_t, double> slips(const auto& memory) {
  std::map<std::int32_t, double> all;
  const auto put = [&all](const auto& table, std::size_t c) {
    REQUIRE(all.emplace(table.place[c], table.numbers[0][c]).second);  // in one table only
  };
  for (std::size_t c = 0; c < memory.springs->size(); ++c) put(*memory.springs, c);
  if (memory.resting == nullptr) return all;
  for (std::size_t c = 0; c < memory.resting->base->size(); ++c)
    if (!memory.resting->is_taken(c)) put(*memory.resting->base, c);
  for (std::size_t c = 0; c < memory.resting->late.size(); ++c) put(memory.resting->late, c);
  return all;
}
/// Each particle is left out with a probability, or changes sides with another.
void shuffle(std::vector<std::uint8_t>& flags, double probability, auto& random) {
  std::bernoulli_distribution flips(probability);
  for (auto& flag : flags)
    if (flips(random)) flag = 1 - flag;
}
}  // namespace

TEST_CASE("however the set changes, the springs of pairs that are left out stay, and none is lost or in two tables") {
  Grains grains = carpet(6);
  grains.v.row(0).setConstant(1e-3);
  PhiStepper stepper{grains, on_floor(), symplectic_euler};
  int n = 0;
  for (; n < 50; ++n) REQUIRE(stepper.step(grains, dt * n, dt));
  std::mt19937 random(7);
  std::vector<std::uint8_t> flags(72, 1);
  shuffle(flags, 0.7, random);
  std::size_t at_rest = 0;
  for (std::uint64_t number = 1; number < 300; ++number, ++n) {
    const auto before = slips(std::get<0>(stepper.memory()));
    const auto walls_before = slips(std::get<1>(stepper.memory()));
    if (number % 3 != 0) shuffle(flags, number % 50 == 0 ? 0.5 : 0.03, random);
    for (Index i = 0; i < 72; ++i)
      if (flags[static_cast<std::size_t>(i)] == 0) grains.v.col(i).setZero(), grains.omega.col(i).setZero();
    stepper.set_active(number % 97 == 0 ? nullptr : set_of(flags, number + 1000));
    REQUIRE(stepper.step(grains, dt * n, dt));
    const auto& memory = std::get<0>(stepper.memory());
    const auto after = slips(memory);
    if (number % 97 == 0) continue;
    const auto is_out = [&](std::int32_t slot) {
      return flags[static_cast<std::size_t>(memory.places->pairs->bodies.particle[static_cast<std::size_t>(slot)])] ==
             0;
    };
    for (const auto& [place, slip] : before) {
      const auto p = static_cast<std::size_t>(place);
      if (!is_out(memory.places->pairs->first[p]) || !is_out(memory.places->pairs->second[p])) continue;
      REQUIRE(after.count(place) == 1);
      REQUIRE(after.at(place) == slip);
      ++at_rest;
    }
    const auto walls_after = slips(std::get<1>(stepper.memory()));
    for (const auto& [place, slip] : walls_before)
      if (flags[static_cast<std::size_t>(place)] == 0) REQUIRE(walls_after.at(place) == slip);
  }
  CHECK(contacts_of(stepper).rebuilds == 1);
  CHECK(at_rest > 3000);
}

TEST_CASE("steps that write a few particles have the bits of steps that write all") {
  const auto check = [](const auto& start, auto force, auto scheme) {
    using State = std::remove_cvref_t<decltype(start)>;
    State a = start, b = start;
    PhiStepper one{a, force, scheme};
    auto left = one.checkpoint();
    std::mt19937 random(11);
    std::vector<std::uint8_t> flags(static_cast<std::size_t>(start.size()), 1);
    shuffle(flags, 0.7, random);
    for (int n = 0; n < 200; ++n) {
      if (n % 7 == 0) shuffle(flags, 0.05, random);
      // One of those left out moves on at its velocity, and edits come now and then: seen without a word.
      if (n % 31 == 0) a.r.col(3).array() += 1e-5, b.r.col(3).array() += 1e-5;
      if (n % 43 == 0) a.v.col(4).setConstant(1e-3), b.v.col(4).setConstant(1e-3);
      const auto set = set_of(flags, 5000 + static_cast<std::uint64_t>(n / 7));
      one.set_active(set);
      REQUIRE(one.step(a, dt * n, dt, n % 31 != 0 && n % 43 != 0 ? Origin::unedited : Origin::unknown));
      PhiStepper other{b, force, scheme};  // whose workspace has seen nothing
      other.restore(left);
      other.set_active(set);
      REQUIRE(other.step(b, dt * n, dt));
      left = other.checkpoint();
      REQUIRE(a.r == b.r);
      REQUIRE(a.v == b.v);
    }
  };
  Grains grains = carpet(4);
  grains.v.row(0).setConstant(1e-3);
  check(grains, on_floor(), symplectic_euler);
  Particles<double, 3> atoms{Eigen::Matrix3Xd(3, 64)};
  for (Index i = 0; i < 64; ++i)
    atoms.r.col(i) << 1.1 * static_cast<double>(i % 4), 1.15 * static_cast<double>(i / 4 % 4),
        1.2 * static_cast<double>(i / 16);
  check(atoms, Pairs{LennardJones{}, 2.0} + Gravity{Vector3d{0, 0, -1}}, velocity_verlet);
}

TEST_CASE("an edit of a particle that is held is seen, and one that is given a velocity moves") {
  Grains grains = carpet(4);
  std::vector<std::uint8_t> still(32, 1);
  still[31] = 0;
  grains.set_still(still);
  PhiStepper stepper{grains, on_floor(), symplectic_euler};
  int n = 0;
  const auto steps = [&](int count, Origin origin) {
    for (const int end = n + count; n < end; ++n) REQUIRE(stepper.step(grains, dt * n, dt, origin));
  };
  steps(5, Origin::unknown);
  grains.r(1, 2) += 0.25;
  const Eigen::Matrix3Xd moved = grains.r;
  steps(2, Origin::unknown);
  CHECK(grains.r.leftCols(31) == moved.leftCols(31));
  steps(5, Origin::unedited);
  CHECK(grains.r.leftCols(31) == moved.leftCols(31));
  grains.r(0, 5) += 0.25;  // after steps that looked at nothing
  grains.v.col(7) << 1, 0, 0;
  const Eigen::Matrix3Xd again = grains.r;
  const std::int64_t rebuilds = contacts_of(stepper).rebuilds;
  steps(100, Origin::unknown);
  CHECK(grains.r.col(5) == again.col(5));
  CHECK_THAT(grains.r(0, 7), Catch::Matchers::WithinRel(again(0, 7) + 100 * dt, 1e-12));
  steps(1900, Origin::unedited);  // … far enough for another list
  CHECK_THAT(grains.r(0, 7), Catch::Matchers::WithinRel(again(0, 7) + 2000 * dt, 1e-12));
  CHECK(contacts_of(stepper).rebuilds + contacts_of(stepper).late > rebuilds);
}

TEST_CASE("in a row that sleeps, who is touched alone is computed, and one that touches it; no list is made for that") {
  Grains grains{Eigen::Matrix3Xd::Zero(3, 13)};
  for (Index i = 0; i < 12; ++i) grains.r.col(i) << 0.9999 * static_cast<double>(i), 0, 0.4999;
  grains.r.col(12) << 0, 50, 1e6;  // falls as long as the test lasts
  grains.set_mass(1.0).set_radius(0.5);
  Sleeping stepper{PhiStepper{grains, on_floor(), symplectic_euler}, SleepOptions{.speed = 1e-3}};
  const std::uint64_t serial = grains.body().serial;
  int n = 0;
  while (stepper.report().asleep < 12 && n < 60000) REQUIRE(stepper.step(grains, dt * n++, dt));
  REQUIRE(stepper.report().asleep == 12);
  const std::int64_t rebuilds = contacts_of(stepper).rebuilds;
  REQUIRE(stepper.step(grains, dt * n++, dt));
  CHECK(contacts_of(stepper).pairs == 0);
  grains.v(1, 0) = 5e-3;
  REQUIRE(stepper.step(grains, dt * n++, dt));
  CHECK_FALSE(stepper.is_asleep(0));
  CHECK_FALSE(stepper.is_asleep(1));
  CHECK(stepper.report().asleep == 10);
  CHECK(contacts_of(stepper).pairs == 2);  // 0-1, 1-2
  CHECK(contacts_of(stepper).rebuilds == rebuilds);
  CHECK(grains.body().serial == serial);
  CHECK(stepper.statistics().force_calls == stepper.statistics().steps);
}

TEST_CASE("where hardly anybody is at rest, nobody sleeps") {
  Grains grains = carpet(5);
  grains.v.setRandom();
  grains.r.row(2).array() += 3;  // in flight
  grains.r.col(0) << -30, 0, 0.499;
  grains.v.col(0).setZero();  // but for one
  Grains twin = grains;
  Sleeping stepper{PhiStepper{grains, on_floor(), symplectic_euler}, SleepOptions{.speed = 1e-2}};
  PhiStepper plain{twin, on_floor(), symplectic_euler};
  for (int n = 0; n < 3000; ++n) {
    REQUIRE(stepper.step(grains, dt * n, dt));
    REQUIRE(plain.step(twin, dt * n, dt));
  }
  CHECK(stepper.report().fell_asleep == 0);
  CHECK(grains.r == twin.r);
}

TEST_CASE("particles left out of pairs get no force, and give theirs") {
  Particles<double, 3> y{Eigen::Matrix3Xd(3, 27)};
  for (Index i = 0; i < 27; ++i)
    y.r.col(i) << 1.1 * static_cast<double>(i % 3), 1.15 * static_cast<double>(i / 3 % 3),
        1.2 * static_cast<double>(i / 9);
  PhiStepper stepper{y, Pairs{LennardJones{}, 2.0}, velocity_verlet};
  Particles<double, 3> all = y, some = y;
  REQUIRE(stepper.slope(0.0, y, all));
  std::vector<std::uint8_t> flags(27, 1);
  for (std::size_t i = 0; i < 27; i += 2) flags[i] = 0;
  stepper.set_active(set_of(flags, 5));
  REQUIRE(stepper.slope(0.0, y, some));
  for (Index i = 0; i < 27; ++i)
    if (i % 2 == 0) CHECK(some.v.col(i) == Vector3d::Zero());
    else CHECK(some.v.col(i) == all.v.col(i));
  CHECK(std::get<0>(std::tie(stepper.force_to_look_at())).rebuilds() == 1);
  // Verlet carries its force: who comes back is not without.
  REQUIRE(stepper.step(y, 0.0, 1e-3));
  stepper.set_active(nullptr);
  REQUIRE(stepper.step(y, 1e-3, 1e-3));
  for (Index i = 0; i < 27; ++i) CHECK(y.v.col(i).norm() > 0);
}
