// Neighbour lists: what is listed, what it costs, and when it is made anew.
#include <phistep/base/archive/archive.hpp>
#include <phistep/particles/bodies/body.hpp>
#include <phistep/particles/neighbors/neighbors.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

const std::vector<std::uint8_t> nobody;

template <int dim>
std::vector<double> random_points(std::int32_t n, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(0, size);
  std::vector<double> r(static_cast<std::size_t>(n * dim));
  for (double& c : r) c = x(random);
  return r;
}

/// (particle, image relative to one's own) of everybody nearer than the range, by trying all.
template <int dim>
using Neighbor = std::pair<std::int32_t, std::array<std::int32_t, 3>>;
template <int dim>
std::vector<Neighbor<dim>> near(const std::vector<double>& r, std::int32_t i, const Domain& domain, double range) {
  std::vector<Neighbor<dim>> all;
  const auto n = static_cast<std::int32_t>(r.size() / dim);
  const auto at = [&](std::int32_t k, int a) { return r[static_cast<std::size_t>(k * dim + a)]; };
  for (std::int32_t j = 0; j < n; ++j) {
    // Around the image that is nearest along each axis, two further ones to both sides.
    std::array<std::int32_t, 3> base{};
    std::array<int, 3> span{};
    for (int a = 0; a < dim; ++a) {
      const auto ua = static_cast<std::size_t>(a);
      if (!domain.periodic[ua]) continue;
      base[ua] = static_cast<std::int32_t>(std::round((at(i, a) - at(j, a)) / domain.length[ua]));
      span[ua] = 2;
    }
    for (int x = -span[0]; x <= span[0]; ++x)
      for (int y = -span[1]; y <= span[1]; ++y)
        for (int z = -span[2]; z <= span[2]; ++z) {
          const std::array<std::int32_t, 3> image{base[0] + x, base[1] + y, base[2] + z};
          if (j == i && image == std::array<std::int32_t, 3>{}) continue;
          double square = 0;
          for (int a = 0; a < dim; ++a) {
            const auto ua = static_cast<std::size_t>(a);
            const double d = at(j, a) + image[ua] * domain.length[ua] - at(i, a);
            square += d * d;
          }
          if (square < range * range) all.push_back({j, image});
        }
  }
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<std::int32_t> slots_of(const NeighborList& list, std::size_t row) {
  std::vector<std::int32_t> all;
  const auto& chunk = list.chunks[row / static_cast<std::size_t>(NeighborList::rows_per_chunk)];
  list.for_each_neighbor(list.rows[row], chunk, [&](std::int32_t slot) { all.push_back(slot); });
  return all;
}

template <int dim>
std::vector<Neighbor<dim>> listed(const NeighborList& list, std::size_t row) {
  std::vector<Neighbor<dim>> all;
  const auto& own = list.slots[static_cast<std::size_t>(list.rows[row].slot)];
  for (const std::int32_t s : slots_of(list, row)) {
    const auto& slot = list.slots[static_cast<std::size_t>(s)];
    auto image = slot.image;
    for (std::size_t a = 0; a < 3; ++a) image[a] -= own.image[a];
    all.push_back({slot.particle, image});
  }
  std::sort(all.begin(), all.end());
  return all;
}

template <int dim>
void check_against_all(const std::vector<double>& r, const Domain& domain, double cutoff, double skin) {
  Neighbors<dim> neighbors;
  NeighborMemory memory;
  const auto n = static_cast<Eigen::Index>(r.size() / dim);
  const NeighborList& list = neighbors.list(r.data(), n, domain, nobody, {cutoff, skin, {}, 8}, memory);
  REQUIRE(list.rows.size() == static_cast<std::size_t>(n));
  std::vector<int> seen(static_cast<std::size_t>(n));
  std::uint64_t sum = 0;
  for (std::size_t row = 0; row < list.rows.size(); ++row) {
    const std::int32_t i = list.slots[static_cast<std::size_t>(list.rows[row].slot)].particle;
    ++seen[static_cast<std::size_t>(i)];
    const auto expected = near<dim>(r, i, domain, cutoff + skin);
    CAPTURE(i);
    REQUIRE(listed<dim>(list, row) == expected);
    sum += expected.size();
    for (const std::int32_t end : list.rows[row].ends) REQUIRE(end % 8 == 0);  // the rest are dummies
    REQUIRE(list.rows[row].ends[2] < static_cast<std::int32_t>(expected.size() + 3 * 8));
  }
  CHECK(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
  CHECK(list.pairs_listed() == sum);
}

Domain box(double length, std::array<bool, 3> periodic) {
  return {{-1.0, 0.5, 0.0}, {length, length + 0.25, length - 0.25}, periodic};
}

}  // namespace

TEST_CASE("a list names exactly those within the range, whatever is periodic") {
  for (const auto& periodic :
       {std::array{false, false, false}, std::array{true, true, true}, std::array{true, false, true}}) {
    CAPTURE(periodic[0], periodic[1], periodic[2]);
    auto r3 = random_points<3>(400, 6, 1);
    check_against_all<3>(r3, box(6, periodic), 1.0, 0.2);
    // Positions run on through the periods.
    for (std::size_t k = 0; k < r3.size(); k += 7)
      if (periodic[k % 3]) r3[k] += box(6, periodic).length[k % 3] * static_cast<double>(static_cast<int>(k) % 11 - 5);
    check_against_all<3>(r3, box(6, periodic), 1.0, 0.2);
    check_against_all<2>(random_points<2>(400, 20, 2), box(20, {periodic[0], periodic[1], false}), 1.0, 0.2);
  }
}

TEST_CASE("in a small box everybody meets several images, and its own") {
  check_against_all<3>(random_points<3>(30, 2, 3), box(2, {true, true, true}), 1.7, 0.1);
  check_against_all<3>(random_points<3>(5, 2, 3), box(2, {true, true, true}), 1.75, 1.0);  // range 2.75 in periods of 2
  check_against_all<2>(random_points<2>(30, 2, 4), box(2, {true, true, false}), 2.0, 0.5);
}

TEST_CASE("particles in a line, at one place, in two far clusters") {
  std::vector<double> r(300, 0.25);
  for (std::size_t i = 0; i < 100; ++i) r[3 * i] = 0.1 * static_cast<double>(i);
  check_against_all<3>(r, {}, 0.5, 0.125);
  check_against_all<3>(std::vector<double>(60, -3.5), {}, 1.0, 0.1);
  auto two = random_points<3>(200, 4, 5);
  for (std::size_t k = 300; k < 600; ++k) two[k] += 1e7;  // 2e7 cells apart, more than the grid has
  check_against_all<3>(two, {}, 1.0, 0.1);
}

TEST_CASE("two bytes a neighbour: counted from one slot, from three, and whole slots where that doesn't do") {
  // Three lines of unit spacing, 1.1 apart. Lines of 40,000 lie too far apart in the list for one slot to count from; where
  // few have rows, a chunk goes along more than 65,536 slots.
  struct Way {
    std::int32_t length, moves_each;
    bool one, near;
  };
  for (const Way& way : {Way{2000, 1, true, true}, Way{40000, 1, false, true}, Way{40000, 300, false, false}}) {
    CAPTURE(way.length, way.moves_each);
    const std::int32_t n = 3 * way.length;
    std::vector<double> r;
    for (std::int32_t i = 0; i < n; ++i) r.push_back(i % way.length), r.push_back(1.1 * (i / way.length));
    std::vector<std::uint8_t> still;
    if (way.moves_each > 1)
      for (std::int32_t i = 0; i < n; ++i) still.push_back(i % way.moves_each != 0);
    Neighbors<2> neighbors;
    NeighborMemory memory;
    const NeighborList& list = neighbors.list(r.data(), n, {}, still, {1.1, 0.1, {}, 4}, memory);
    const NeighborList::Chunk& first = list.chunks[0];
    CHECK((first.base[0] == first.base[2]) == (way.one || !way.near));
    CHECK(first.slots.empty() == way.near);
    CHECK(list.rows.size() == static_cast<std::size_t>((n - 1) / way.moves_each + 1));
    bool all_right = true;
    for (std::size_t row = 0; row < list.rows.size(); ++row) {
      const std::int32_t i = list.slots[static_cast<std::size_t>(list.rows[row].slot)].particle;
      std::vector<std::int32_t> expected, found;
      const std::int32_t x = i % way.length, y = i / way.length;
      if (y > 0) expected.push_back(i - way.length);
      if (x > 0) expected.push_back(i - 1);
      if (x + 1 < way.length) expected.push_back(i + 1);
      if (y < 2) expected.push_back(i + way.length);
      for (const std::int32_t s : slots_of(list, row))
        found.push_back(list.slots[static_cast<std::size_t>(s)].particle);
      std::sort(found.begin(), found.end());
      all_right &= found == expected;
    }
    CHECK(all_right);
  }
}

TEST_CASE("a simple cubic lattice: the counts are those of the lattice") {
  // n³ sites 1 apart, periodic. Within 1.8: 6 at 1, 12 at √2, 8 at √3. Cells of 0.9 along x and 1.8 along y and z (and a
  // rounding reserve): the sites at k = 0 … n + 3 of an axis, ghosts included, stand in cell ⌊k/0.9⌋ or ⌊k/1.8⌋.
  constexpr int n = 9;
  std::vector<double> r;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (const int c : {x, y, z}) r.push_back(c + 0.5);
  Neighbors<3> neighbors;
  NeighborMemory memory;
  const Domain domain{{}, {n, n, n}, {true, true, true}};
  const NeighborList& list = neighbors.list(r.data(), n * n * n, domain, nobody, {1.5, 0.3, {}, 4}, memory);
  CHECK(list.pairs_listed() == 26 * n * n * n);
  // Ghosts reach from −1.8 to n + 1.8, hence from −1.5 to n + 1.5: two beyond each face.
  const auto pairs_along = [](double edge, std::int64_t reach) {
    const auto cell = [edge](int k) { return static_cast<std::int64_t>(k / (edge * (1 + 1e-8))); };
    std::int64_t pairs = 0;
    for (int k = 2; k < n + 2; ++k)
      for (int other = 0; other < n + 4; ++other) pairs += std::abs(cell(other) - cell(k)) <= reach ? 1 : 0;
    return pairs;
  };
  const std::int64_t x = pairs_along(0.9, 2), y = pairs_along(1.8, 1);
  CHECK(list.slots.size() == static_cast<std::size_t>((n + 4) * (n + 4) * (n + 4)) + 1);  // and a dummy
  CHECK(list.pairs_tested() == static_cast<std::uint64_t>(x * y * y - n * n * n));
}

TEST_CASE("a list serves until the two largest displacements exceed the skin") {
  auto r = random_points<3>(50, 5, 6);
  Neighbors<3> neighbors;
  NeighborMemory memory;
  const NeighborRange range{1.0, 0.5};
  const auto ask = [&] { static_cast<void>(neighbors.list(r.data(), 50, {}, nobody, range, memory)); };
  ask();
  CHECK(neighbors.rebuilds() == 1);
  const double x0 = r[3 * 7];
  for (int step = 1; step <= 9; ++step) {  // one particle, 1/8 a step: 4/8 still serves, 5/8 does not; then from there
    r[3 * 7] = x0 + step / 8.0;
    ask();
    CAPTURE(step);
    CHECK(neighbors.rebuilds() == (step < 5 ? 1u : 2u));
  }
  r[3 * 7] += 1 / 8.0;  // 5/8 since the second list
  ask();
  CHECK(neighbors.rebuilds() == 3);
  r[3 * 7] += 0.25, r[3 * 9 + 1] -= 0.25;  // two by 1/4 each: just serves
  ask();
  CHECK(neighbors.rebuilds() == 3);
  r[3 * 11 + 2] -= 0.25;  // a third one is no matter
  ask();
  CHECK(neighbors.rebuilds() == 3);
  r[3 * 9 + 1] -= 0.0625;
  ask();
  CHECK(neighbors.rebuilds() == 4);
}

TEST_CASE("an unchecked list is made anew every n steps, moved or not") {
  auto r = random_points<3>(20, 3, 6);
  Neighbors<3> neighbors;
  NeighborMemory memory;
  for (int step = 0; step <= 60; ++step) {  // step 0: before the first; then one question a step
    r[0] += 1e-3;
    static_cast<void>(neighbors.list(r.data(), 20, {}, nobody, {1.0, 0.3, 20}, memory));
    CHECK(neighbors.rebuilds() == 1u + static_cast<unsigned>(step) / 20u);
    if (step > 0) ++memory.age;
  }
}

TEST_CASE("a pair of two that are still is no pair") {
  const auto r = random_points<3>(200, 4, 8);
  std::vector<std::uint8_t> still(200);
  for (std::size_t i = 0; i < still.size(); ++i) still[i] = i % 3 != 0;
  Neighbors<3> neighbors;
  NeighborMemory memory;
  const NeighborList& list = neighbors.list(r.data(), 200, {}, still, {1.0, 0.2}, memory);
  REQUIRE(list.rows.size() == 67);
  for (std::size_t row = 0; row < list.rows.size(); ++row) {
    const std::int32_t i = list.slots[static_cast<std::size_t>(list.rows[row].slot)].particle;
    CHECK(i % 3 == 0);
    CHECK(listed<3>(list, row) == near<3>(r, i, {}, 1.2));
  }
  // Who is still is part of what a list is made from.
  still.assign(200, 1);
  CHECK(neighbors.list(r.data(), 200, {}, still, {1.0, 0.2}, memory).rows.empty());
  CHECK(neighbors.rebuilds() == 2);
  CHECK(neighbors.pairs_tested() == 0);
}

TEST_CASE("who flew off costs the others nothing") {
  constexpr std::int32_t n = 20000;
  auto r = random_points<3>(n, 20, 9);  // 2.5 in a unit of volume
  Neighbors<3> neighbors;
  NeighborMemory memory;
  static_cast<void>(neighbors.list(r.data(), n, {}, nobody, {1.0, 0.1}, memory));
  const std::uint64_t before = neighbors.pairs_tested();
  for (const double far : {1e9, -1e300, std::numeric_limits<double>::infinity()}) {
    auto moved = r;
    moved[3 * 100] = far, moved[3 * 200 + 1] = -far, moved[3 * 300 + 2] = 7 * far;
    NeighborMemory fresh;
    const NeighborList& list = neighbors.list(moved.data(), n, {}, nobody, {1.0, 0.1}, fresh);
    CHECK(list.rows.size() == static_cast<std::size_t>(n));
    // The grid starts elsewhere, so that its cells hold others: a few percent.
    CHECK(static_cast<double>(neighbors.pairs_tested()) < 1.1 * static_cast<double>(before));
  }
}

TEST_CASE("who flew off from a periodic box, to either side, has no images beyond count") {
  const auto r = random_points<3>(100, 6, 12);
  const Domain periodic = box(6, {true, true, true});
  for (const double far : {1e9, 1e10, 1e12, 1e18, 1e300})
    for (const double side : {far, -far}) {
      auto moved = r;
      moved[3 * 10] = side, moved[3 * 20 + 1] = -side, moved[3 * 30 + 2] = side;
      Neighbors<3> neighbors;
      NeighborMemory memory;
      const NeighborList& list = neighbors.list(moved.data(), 100, periodic, nobody, {1.0, 0.1}, memory);
      CHECK(list.slots.size() < 600);  // 27 images of those near a corner at the most
    }
}

TEST_CASE("what is not a number is near nobody, and takes no time") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Domain& domain : {Domain{}, box(6, {true, true, true})}) {
    auto r = random_points<3>(100, 6, 10);
    r[0] = nan, r[31] = -std::numeric_limits<double>::infinity();
    Neighbors<3> neighbors;
    NeighborMemory memory;
    const auto list = neighbors.list(r.data(), 100, domain, nobody, {1.0, 0.1}, memory);
    REQUIRE(list.rows.size() == 100);
    for (std::size_t row = 0; row < 100; ++row) {
      const std::int32_t i = list.slots[static_cast<std::size_t>(list.rows[row].slot)].particle;
      if (i == 0 || i == 10) CHECK(list.rows[row].ends[2] == 0);
      for (const std::int32_t s : slots_of(list, row))
        CHECK((list.slots[static_cast<std::size_t>(s)].particle != 0 &&
               list.slots[static_cast<std::size_t>(s)].particle != 10));
    }
    // It has not moved either: the list is not made anew at every call.
    static_cast<void>(neighbors.list(r.data(), 100, domain, nobody, {1.0, 0.1}, memory));
    CHECK(neighbors.rebuilds() == 1);
  }
  const std::vector<double> all(3 * 100000, nan);
  Neighbors<3> neighbors;
  NeighborMemory memory;
  CHECK(neighbors.list(all.data(), 100000, {}, nobody, {1.0, 0.1}, memory).pairs_tested() == 0);
}

TEST_CASE("nobody, and one alone") {
  Neighbors<3> neighbors;
  NeighborMemory memory;
  const std::vector<double> r{1, 2, 3};
  CHECK(neighbors.list(r.data(), 0, {}, nobody, {1.0, 0.1}, memory).rows.empty());
  CHECK(neighbors.list(r.data(), 1, {}, nobody, {1.0, 0.1}, memory).rows.size() == 1);
  CHECK(neighbors.pairs_listed() == 0);
}

TEST_CASE("a cutoff larger than the box is refused") {
  Neighbors<3> neighbors;
  NeighborMemory memory;
  const std::vector<double> r{1, 2, 3};
  CHECK_THROWS_AS(neighbors.list(r.data(), 1, box(2, {true, true, true}), nobody, {2.0, 0.1}, memory),
                  std::invalid_argument);  // z has a period of 1.75
  CHECK_NOTHROW(neighbors.list(r.data(), 1, box(2, {true, true, false}), nobody, {2.0, 0.1}, memory));
  // So is a skin in which a list would serve for longer than the images that it has.
  NeighborMemory fresh;
  CHECK_THROWS_AS(neighbors.list(r.data(), 1, box(2, {true, true, false}), nobody, {1.0, 20.0}, fresh),
                  std::invalid_argument);
}

TEST_CASE("a memory that goes back takes the list with it, bit for bit") {
  auto r = random_points<3>(300, 5, 11);
  Neighbors<3> neighbors;
  NeighborMemory memory;
  const NeighborRange range{1.0, 0.3, {}, 8};
  const Domain domain = box(5, {true, true, true});
  const auto rows = [&](const NeighborMemory& with) {
    const NeighborList& list = neighbors.list(r.data(), 300, domain, nobody, range, with);
    std::vector<std::int32_t> all;
    for (std::size_t row = 0; row < list.rows.size(); ++row) {
      all.push_back(list.slots[static_cast<std::size_t>(list.rows[row].slot)].particle);
      for (const std::int32_t s : slots_of(list, row)) all.push_back(s);
    }
    return all;
  };
  const auto first = rows(memory);
  const NeighborMemory before = memory;
  const auto kept = r;
  for (double& x : r) x += 0.2 * std::sin(100 * x);
  CHECK(rows(memory) != first);  // a trial, rejected
  r = kept;
  CHECK(rows(before) == first);
  // … and through a checkpoint.
  Writer out;
  NeighborMemory copy = before;
  out(copy);
  NeighborMemory restored;
  Reader in{out.bytes()};
  in(restored);
  in.finish();
  REQUIRE(restored.reference != nullptr);
  r[0] += 0.01;  // within the skin: the list is that of the reference, not of here
  Neighbors<3> elsewhere;
  CHECK(elsewhere.list(r.data(), 300, domain, nobody, range, restored).pairs_listed() ==
        neighbors.list(r.data(), 300, domain, nobody, range, before).pairs_listed());
  r = kept;
  neighbors = Neighbors<3>{};
  CHECK(restored.reference->positions == before.reference->positions);
  CHECK(rows(restored) == first);
}

TEST_CASE("a checkpoint holds a list's age; one whose numbers aren't finite is refused") {
  const auto r = random_points<3>(20, 3, 6);
  Neighbors<3> neighbors;
  NeighborMemory memory;
  static_cast<void>(neighbors.list(r.data(), 20, box(4, {true, true, true}), nobody, {1.0, 0.3}, memory));
  const auto copied = [](const NeighborMemory& from) {
    Writer out;
    out(from);
    NeighborMemory to;
    Reader in{out.bytes()};
    in(to);
    in.finish();
    return to;
  };
  for (const std::int32_t age : {-1, 0, 7}) {
    memory.age = age;
    CHECK(copied(memory).age == age);
  }
  memory.age = -2;
  CHECK_THROWS_AS(copied(memory), CheckpointError);
  const auto spoiled = [&](auto&& spoil) {
    NeighborReference reference = *memory.reference;
    spoil(reference);
    NeighborMemory bad;
    bad.reference = std::make_shared<const NeighborReference>(reference);
    return bad;
  };
  CHECK_NOTHROW(copied(spoiled([](auto&) {})));
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    // Where positions aren't numbers, nothing has moved from there: the list would serve for ever.
    CHECK_THROWS_AS(copied(spoiled([bad](auto& x) { x.positions[31] = bad; })), CheckpointError);
    CHECK_THROWS_AS(copied(spoiled([bad](auto& x) { x.domain.lower[1] = bad; })), CheckpointError);
    CHECK_THROWS_AS(copied(spoiled([bad](auto& x) { x.domain.length[2] = bad; })), CheckpointError);
  }
}
