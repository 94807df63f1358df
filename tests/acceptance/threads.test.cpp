// One thread or two: the same bits, through neighbour lists made anew. Implicit, and over long runs: threads.full.cpp.
#include "acceptance/threads_cases.hpp"

TEST_CASE("Lennard-Jones by velocity Verlet, 300 steps") {
  // 1331 rows are three chunks: two threads share them.
  check(fluid(11), 300, 0.004, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.4}}, velocity_verlet};
        }));
}

TEST_CASE("gravity among all") {
  Atoms stars = fluid(9);
  stars.set_box(Box<double, 3>::open()).set_mass(1e-3);
  check(stars, 40, 0.01, by([](const Atoms& y) {
          return PhiStepper{y, AllPairs{SoftenedGravity{1.0, 0.1}}, velocity_verlet};
        }));
}

TEST_CASE("the energy of all pairs has the same bits with one thread, two and three") {
  Atoms stars = fluid(11);  // several teams of 256
  stars.set_box(Box<double, 3>::open()).set_mass(1e-3);
  const auto energy = [&stars](int threads) {
    omp_set_num_threads(threads);
    const AllPairs gravity{SoftenedGravity{1.0, 0.1}};
    const auto masses = Atoms::masses(stars);
    return gravity.energy(0, Blocks<Atoms>::view(stars, masses));
  };
  const double one = energy(1);
  CHECK(one < 0);
  CHECK(energy(2) == one);
  CHECK(energy(3) == one);
}
