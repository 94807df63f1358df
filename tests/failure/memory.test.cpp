// Every allocation of a run fails once: std::bad_alloc, nothing half done, nothing leaked. memory.stress.cpp does more.
#include "failure/memory_cases.hpp"

using namespace memory_cases;

TEST_CASE("a run with an event and a recorder, saved and loaded, starved at every allocation") {
  const auto pulled = [](auto& y) { return PhiStepper{y, Still{}, velocity_verlet}; };
  const auto watched = [] { return std::tuple{Recorder<Motion<Vec>>{}}; };
  check(every_allocation("watched", machine(motion, pulled, 0.3, fixed(0.1), watched),
                         {.same_end = 1e-13, .moves_on = true}));
}

TEST_CASE("a Recorder without memory keeps what it has") {
  Recorder<Vec> recorder;
  const Vec y = Vec::LinSpaced(5, 0, 1);
  int thrown = 0;
  for (int n = 0; n < 40; ++n) {
    const Index before = recorder.size();
    heap::count = 0, heap::fatal = n % 2, heap::lasting = true;  // for the times, or for the values
    const Act act = fed([&] { recorder(n, y); });
    heap::fatal = -1;
    thrown += act == Act::starved;
    CHECK(recorder.size() == before + (act == Act::done ? 1 : 0));
    for (Index k = 0; k < recorder.size(); ++k) CHECK((recorder.states().col(k) == y));
    if (act != Act::done) recorder(n, y);
  }
  CHECK(thrown > 2);
}
