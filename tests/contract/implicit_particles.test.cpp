// Particles through the implicit solve: the neighbour list is the sparsity pattern. More: implicit_particles.full.cpp.
#include <phistep/particles.hpp>

#include <cmath>
#include <string_view>

#include "contract/implicit_particles_cases.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace implicit_particles;

TEST_CASE("the neighbour list is the pattern: analysed once for each list, solved by edges") {
  Atoms atoms = crystal(0.3);
  PhiStepper stepper{atoms, argon(), trapezoidal};
  CHECK(std::string_view{stepper.solver_name()} == "block-Jacobi conjugate gradients on the edge operator");
  const double E0 = energy(stepper.force(), atoms);
  for (int n = 0; n < 60; ++n) REQUIRE(stepper.step(atoms, 0.01 * n, 0.01));
  const Statistics& work = stepper.statistics();
  const auto lists = static_cast<std::int64_t>(stepper.force_to_look_at().rebuilds());
  CHECK(lists > 1);
  CHECK(work.analyses <= lists);
  CHECK(work.analyses > 1);
  CHECK(work.jacobians > work.analyses);
  // φ = ½ conserves no energy but nearly that of a nearby system: at this Δt the ripple is 2e-4 of E.
  CHECK(std::abs(energy(stepper.force(), atoms) - E0) < 1e-3 * std::abs(E0));
  CHECK(atoms.v.rowwise().sum().norm() < 1e-11);
}

TEST_CASE("a step with a solve is the step of the formula") { check_formula(trapezoidal, 0.5); }

TEST_CASE("a rejected step leaves no trace: what follows is bit-equal to a run without it") {
  Atoms a = crystal(1.0), b = a;
  PhiStepper straight{a, argon(), trapezoidal}, interrupted{b, argon(), trapezoidal};
  for (int n = 0; n < 40; ++n) {
    if (n % 5 == 3) {
      // A long step moves particles far enough for a new list; then it is taken back. Matrices stay as they are: here
      // both steppers forget theirs.
      const auto past = interrupted.checkpoint();
      Atoms copy = b;
      static_cast<void>(interrupted.step(copy, 0.005 * n, 0.05));
      interrupted.restore(past);
      interrupted.reset(), straight.reset();
    }
    REQUIRE(straight.step(a, 0.005 * n, 0.005));
    REQUIRE(interrupted.step(b, 0.005 * n, 0.005));
  }
  CHECK(interrupted.force_to_look_at().rebuilds() > straight.force_to_look_at().rebuilds());
  CHECK(a.r == b.r);
  CHECK(a.v == b.v);
}
