// Random sequences of steps, failures, edits, checkpoints and resets against fresh steppers. Explicit ones, and
// particles: machine.full.cpp.
#include "properties/machine_vectors.hpp"

using namespace machine;

TEST_CASE("whatever was done before, the next step is a fresh stepper's") {
  for (const Promise& each : {
           promise<DampedSwing<phi_07>>("phi = 0.7, Newton", false, false, 64, 1, 4),
       })
    property::check(each.name, 200, [&each](Source& source) { live(source, each); });
}
