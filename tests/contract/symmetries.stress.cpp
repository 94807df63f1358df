// Symmetries, over generated particles and forces between them.
#include "contract/symmetries.hpp"

TEST_CASE("turned, mirrored, shifted, boosted and renamed particles move as they would have") {
  property::report("turned, mirrored, shifted, boosted, renamed", 20000, particles::symmetry);
}
TEST_CASE("a mirror changes no bit") {
  property::report("springs, all pairs mirrored: the same bits", 10000, particles::mirror);
}
TEST_CASE("forces between particles keep the momentum") {
  property::report("particles: momentum is kept", 20000, particles::momentum);
}
TEST_CASE("threads change no bit") {
  property::report("1 to 4 threads: the same bits and counts", 1000, particles::threads);
}
