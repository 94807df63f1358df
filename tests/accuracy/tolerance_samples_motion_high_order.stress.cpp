// A state inside of a step is as accurate as those at its ends: motions by stiff schemes. In short:
// tolerance_samples.test.cpp.

#include "accuracy/tolerance_samples_cases.hpp"

using namespace samples;

TEST_CASE("samples are as accurate as steps") {
  check_motion("Rodas4", rodas4, 3, 10);
  check_motion("Rodas5P", rodas5p, 3, 10);
  check_motion("Radau", radau, 3, 10);
  for (const int stages : {3, 5, 7}) check_motion("Radau of given stages", radau(stages), 3, 10);
  check_motion("phi = 0.7", phi(0.7), 3, 5);
  check_motion("Rannacher", rannacher, 3, 8);
}
