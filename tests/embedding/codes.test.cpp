// Three codes with loops of their own (examples/existing_codes): the same scheme, embedded, gives the same bits for as many
// calls of their force routines.
#include "embedding/codes_cases.hpp"

using namespace codes_cases;

namespace {

/// Twice, since the second run starts from forces of the first.
template <class Loop>
void compare(auto& before, auto& after, int steps) {
  for (int run = 0; run < 2; ++run) {
    const Numbers start = state_of(before);
    Loop::run(before, steps);
    Loop::run(after, steps);
    CHECK(distance(start, state_of(before)) > 1e-4);
    CHECK(same_bits(state_of(after), state_of(before)));
    CHECK(same_bits(forces_of(after), forces_of(before)));
    CHECK(after.force_calls == before.force_calls);
  }
}

}  // namespace

TEST_CASE("an array of structs: masses on springs, semi-implicit Euler and velocity Verlet") {
  static_assert(sizeof(before::Bead) == 96);
  for (const int n : {4, 100, 1024}) {
    before::Cloth a(n);
    after::Cloth b(n);
    compare<Verlet>(a, b, 100);
    compare<Euler>(a, b, 100);
    CHECK(a.force_calls == 2 * (100 + 1) + 2 * 100);
  }
}

TEST_CASE("an array of structs: dashpots and drag") {
  before::ClothParameters p;
  after::ClothParameters q;
  p.spring_damping = q.spring_damping = 1e-3;
  p.air_drag = q.air_drag = 1e-4;
  before::Cloth a(400, p);
  after::Cloth b(400, q);
  compare<Euler>(a, b, 200);
}

TEST_CASE("double (*x)[3]: molecular dynamics with cells, and with too few atoms for cells") {
  for (const int n : {100, 700}) {
    before::MolecularDynamics a(n);
    after::MolecularDynamics b(n);
    compare<Atoms>(a, b, 50);
    CHECK(a.force_calls == 2 * (50 + 1));
    CHECK(a.energy() == b.energy());
    CHECK(a.pressure() == b.pressure());
  }
}

TEST_CASE("a raw double*: heat by finite differences") {
  for (const int n : {4, 400}) {
    before::HeatPlate a(n);
    after::HeatPlate b(n);
    compare<Heat>(a, b, 200);
    CHECK(a.force_calls == 2 * 200);
    CHECK(a.time == b.time);
    CHECK(a.step_number == b.step_number);
    CHECK(a.heat_supply() == b.heat_supply());
  }
}
