// memory: the full product and what is dear to compile. The quick half is memory.test.cpp.
#include "failure/memory_cases.hpp"

using namespace memory_cases;

TEST_CASE("a run with an event and a recorder, saved and loaded, starved at every allocation") {
  const auto watched = [] {
    return std::tuple{event([](const auto& y) { return y.r[0] - 0.35; }, {}, [](double, auto& y) { y.v[0] *= -0.9; }),
                      Recorder<Motion<Vec>>{}};
  };
  check(every_allocation("watched", machine(motion, verlet, 0.3, fixed(0.1), watched),
                         {.same_end = 1e-13, .moves_on = true}));
}
