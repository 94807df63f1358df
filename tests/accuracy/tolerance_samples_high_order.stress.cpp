// A state inside of a step is as accurate as those at its ends: Rosenbrock schemes and Radau. In short:
// tolerance_samples.test.cpp.

#include "accuracy/tolerance_samples_cases.hpp"

using namespace samples;

TEST_CASE("samples are as accurate as steps") {
  check_flow("Rodas4", rodas4, smooth, 3, 10);
  check_flow("Rodas4", rodas4, stiff, 3, 8);
  check_flow("Rodas5P", rodas5p, smooth, 3, 10);
  check_flow("Rodas5P", rodas5p, stiff, 3, 10);
  check_flow("Radau", radau, smooth, 3, 10);
  check_flow("Radau", radau, stiff, 3, 10);
  for (const int stages : {3, 5, 7}) {
    check_flow("Radau of given stages", radau(stages), smooth, 3, 10);
    check_flow("Radau of given stages", radau(stages), stiff, 3, 10);
  }
}

TEST_CASE("samples are as accurate as steps, in a stepper around a stepper") {
  check("Halving, Rodas4", {Problem::rotation, Problem::robinson_1e6}, 3, 7, [&](Problem p, double rtol) {
    const Two<double> start = solution(p).start().head<2>().cast<double>();
    return errors(p, rtol, start, [&](const Two<double>& y) {
      return Halving{PhiStepper{y, Flow<double>{p}, rodas4}};
    });
  });
}

TEST_CASE("samples are as accurate as steps, in float") {
  check_flow<float>("TR-BDF2", tr_bdf2, {Problem::van_der_pol, Problem::robinson_1e4}, 3, 4);
  check_flow<float>("Rodas5P", rodas5p, {Problem::van_der_pol, Problem::robinson_1e4}, 3, 4);
  check_motion<float>("rkn86", rkn86, 3, 4);
}
