// A state inside of a step is as accurate as those at its ends, and to look at it changes nothing. Here one scheme of each
// kind: Hermite's interpolant, a continuous extension, the pairs', step doubling. All of them: tolerance_samples*.full.cpp.
//
// Found before states inside were checked, in units of rtol, where the ends were right to 4: 2e3 (TR-BDF2, stiff), 1e5
// (Rodas4, stiff), 4e6 (Radau, stiff), 400 (rkn1210), 90 (rkn86), 8e5 (srkn11b), 1e6 (composed).

#include "acceptance/tolerance_samples_cases.hpp"

using namespace samples;

TEST_CASE("samples are as accurate as steps") {
  check_flow("TR-BDF2", tr_bdf2, {Problem::rotation, Problem::robinson_1e6}, 3, 5);
  check_flow("Rodas5P", rodas5p, {Problem::van_der_pol, Problem::robinson_1e6}, 3, 9);
  check_motion("rkn1210", rkn1210, 3, 12);
  check_motion("srkn11b", srkn11b, 4, 9);
}
