// Random sequences of steps, failures, edits, checkpoints and resets against fresh steppers, explicit and of particles.
// The quick half: machine.test.cpp.
#include "properties/machine_cases.hpp"

using namespace machine;

TEST_CASE("whatever was done before, the next step is a fresh stepper's") {
  for (const Promise& each : {
           promise<Swing<velocity_verlet>>("velocity Verlet", true, true, 0, 1, 5),
           with_list(promise<GasByVerlet>("a gas by Verlet", false, true, 64, 1, 9)),
           promise<Grains>("grains with friction", true, true, 0, 1, 6),
       })
    property::check(each.name, 200, [&each](Source& source) { live(source, each); });
}
