// The memory of contacts as bytes: what comes back, and what is refused.
#include <phistep/base/archive/archive.hpp>
#include <phistep/particles/contacts/contact_memory.hpp>
#include <phistep/particles/contacts/contact_pairs.hpp>
#include <phistep/particles/contacts/spring_table.hpp>
#include <phistep/particles/walls/wall_shapes.hpp>
#include <phistep/particles/walls/walls.hpp>

#include <cmath>
#include <memory>
#include <vector>

#include "support/catch.hpp"

using namespace phistep;

namespace {

template <class T>
T copied(const T& from) {
  Writer out;
  out(from);
  T to;
  Reader in{out.bytes()};
  in(to);
  in.finish();
  return to;
}

/// Every number of x is refused where it isn't finite. `number(x)` refers to one of them.
template <class T>
void check_refused(const T& good, auto&&... number) {
  CHECK_NOTHROW(copied(good));
  const auto spoil = [&good](auto& of) {
    for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      T spoiled = good;
      of(spoiled) = bad;
      CHECK_THROWS_AS(copied(spoiled), CheckpointError);
    }
  };
  (spoil(number), ...);
}

template <class Place = std::int32_t>
SpringTable<double, Place> one_contact() {
  SpringTable<double, Place> table;
  table.resize(1, true);
  table.close();
  table.place[0] = 3;
  for (std::size_t a = 0; a < 3; ++a) table.numbers[a][0] = 0.25, table.numbers[3 + a][0] = -0.5;
  return table;
}

}  // namespace

TEST_CASE("what contacts remember is finite, or no memory of theirs") {
  using Memory = ContactMemory<SpringTable<double, std::int64_t>, WallBodies>;
  Memory memory;
  memory.time = 3, memory.step = 0.5, memory.lag = 0.125;
  const Memory again = copied(memory);
  CHECK(again.time == 3);
  CHECK(again.step == 0.5);
  CHECK(again.elapsed(3.25) == 0.375);
  check_refused(
      memory, [](Memory& m) -> double& { return m.time; }, [](Memory& m) -> double& { return m.step; },
      [](Memory& m) -> double& { return m.lag; });

  using Table = SpringTable<double>;
  CHECK(copied(one_contact()).numbers[5][0] == -0.5);
  check_refused(
      one_contact(), [](Table& t) -> double& { return t.numbers[1][0]; },
      [](Table& t) -> double& { return t.numbers[5][0]; });

  using Springs = SpringTable<double, std::int64_t>;
  check_refused(
      one_contact<std::int64_t>(), [](Springs& s) -> double& { return s.numbers[2][0]; },
      [](Springs& s) -> double& { return s.numbers[3][0]; });
}

TEST_CASE("a new contact finds unstretched springs behind the last one, in a checkpoint as well") {
  SpringTable<double> table = one_contact();
  table.numbers[0][5] = 1;
  CHECK_THROWS_AS(copied(table), CheckpointError);
}

TEST_CASE("where contacts were looked for is finite, or no place") {
  using Pairs3 = ContactPairs<double>;
  Pairs3 pairs;
  pairs.bodies.particle = {0};
  pairs.bodies.id = {7};
  pairs.bodies.radius = {0.5};
  pairs.bodies.inverse_mass = {1};
  pairs.bodies.type = {0};
  pairs.first.assign(Pairs3::padding, 0);
  pairs.second.assign(Pairs3::padding, 0);
  pairs.row = {0, 0};
  pairs.built_at = {1, 2, 3};
  pairs.skin = 0.1;
  check_refused(
      pairs, [](Pairs3& p) -> double& { return p.built_at[1]; }, [](Pairs3& p) -> double& { return p.skin; },
      [](Pairs3& p) -> double& { return p.period[2]; });
}
