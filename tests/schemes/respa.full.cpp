// Slow terms called once in k inner steps: faults inside a step and restarts; the others: respa.test.
#include "schemes/respa_cases.hpp"

#include <sstream>
#include <string>

#include "contract/restart.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace respa_cases;

TEST_CASE("a fault at any call inside a step: state, histories and their counts are those before it") {
  using namespace faults;
  const Make make = machine(six, sliding, 0.5, fixed(0.1));
  // A new run from a fault on counts its times from there.
  const Tally all = every_call("slow terms", make, Site::force, {Kind::nan, Kind::inf, Kind::exception},
                               {.same_end = 1e-13, .renewed = 1e-12});
  INFO(all.first);
  CHECK(all.clean());
  CHECK(all.failures > 500);
  const auto pulls = [](const auto& y) {
    return PhiStepper{y, term(pull) + seldom(2, pull) + seldom(4, pull), symplectic_euler};
  };
  const Tally sizes = every_call("sizes", machine(six, pulls, 0.3, fixed(0.1)), Site::force,
                                 {Kind::size, Kind::exception}, {.same_end = 1e-13, .renewed = 1e-12});
  INFO(sizes.first);
  CHECK(sizes.clean());
  CHECK(sizes.failures > 40);
  fault = {};
}

TEST_CASE("slow terms restart to the same bits, counts by term included") {
  faults::fault = {};
  const restart::Steps uneven{0.05, false};
  const Statistics s = restart::check(uneven, six, sliding);
  CHECK(s.kick_calls == 60 * 2 + 1 + 60 + 1);
  auto y = six();
  auto stepper = sliding(y);
  for (int n = 0; n < 5; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  const std::string saved = restart::bytes(stepper, y);
  auto z = six();
  auto other = sliding(z);
  std::istringstream in(saved);
  load_checkpoint(in, other, z);
  CHECK(other.calls_by_term() == stepper.calls_by_term());
}
