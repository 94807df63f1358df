// One thread or two: the same bits, implicit and over long runs. The quick half: threads.test.cpp.
#include "acceptance/threads_cases.hpp"

TEST_CASE("Lennard-Jones by velocity Verlet, 10,000 steps") {
  // 1331 rows are three chunks: two threads share them.
  check(fluid(11), 10000, 0.004, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.4}}, velocity_verlet};
        }));
}

TEST_CASE("Lennard-Jones by the trapezoidal rule: Newton, conjugate gradients, the list as their pattern") {
  check(fluid(9), 40, 0.02, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 1.8, {.skin = 0.4}}, trapezoidal,
                            newton({.rtol = 1e-6, .atol = 1e-9})};
        }));
}

// Minutes long: acceptance_threads "[long]"
TEST_CASE("over 10,000 steps, explicit and implicit", "[.long]") {
  check(fluid(11), 10000, 0.004, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 2.2, {.skin = 0.4}}, velocity_verlet};
        }));
  check(fluid(9), 10000, 0.02, by([](const Atoms& y) {
          return PhiStepper{y, Pairs{LennardJones{}, 1.8, {.skin = 0.4}}, trapezoidal,
                            newton({.rtol = 1e-6, .atol = 1e-9})};
        }));
}
