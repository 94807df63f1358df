// Particles through the implicit solve: with a bonded net, and by backward Euler. The quick half:
// implicit_particles.test.cpp.
#include <phistep/particles.hpp>

#include <cmath>
#include <string_view>
#include <vector>

#include "contract/implicit_particles_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace implicit_particles;

TEST_CASE("a step with a solve is the step of the formula") {
  check_formula(trapezoidal, 0.5);
  check_formula(backward_euler, 1.0);
}

TEST_CASE("a bonded net among repelling particles is one solve") {
  Atoms atoms = crystal(0.1);
  std::vector<Spring> bonds;
  for (int k = 0; k + 1 < 216; ++k)
    if (k % 6 != 5) bonds.push_back({k, k + 1, 1e6, std::pow(2.0, 1.0 / 6)});
  auto force = argon() + spring_network<3>(bonds);
  PhiStepper stepper{atoms, force, backward_euler};
  CHECK(std::string_view{stepper.solver_name()} == "block-Jacobi conjugate gradients on the edge operator");
  for (int n = 0; n < 20; ++n) {
    const StepReport report = stepper.step(atoms, 0.01 * n, 0.01);  // 7 times the explicit limit of the bonds
    INFO(report.message());
    REQUIRE(report);
  }
  // Backward Euler damps what it doesn't resolve: the bonds are at rest.
  for (const Spring& s : bonds) CHECK(std::abs((atoms.r.col(s.i) - atoms.r.col(s.j)).norm() - s.length) < 1e-4);
}

TEST_CASE("two atoms that were swapped: no step fails that a fresh stepper takes") {
  // As many corrections as a fresh stepper may need: those on the old matrix must not count.
  int compared = 0, stalled = 0;
  for (const int most : {3, 4, 5, 6, 7}) {
    for (Index k = 1; k < 216; k += 23) {
      Atoms atoms = crystal(0.5);
      const NewtonOptions options{.max_iterations = most};
      PhiStepper stepper{atoms, argon(), trapezoidal, newton(options)};
      if (!stepper.step(atoms, 0.0, 0.01)) continue;
      atoms.r.col(0).swap(atoms.r.col(k));
      Atoms same = atoms;
      PhiStepper fresh{same, argon(), trapezoidal, newton(options)};
      if (!fresh.step(same, 0.01, 0.01)) continue;
      ++compared;
      stalled += !stepper.step(atoms, 0.01, 0.01);
    }
  }
  CHECK(compared >= 10);
  CHECK(stalled == 0);
}
