// Particles through the implicit solve: the neighbour list is the sparsity pattern. More: the stress tier.
#include <phistep/particles.hpp>
#include <phistep/particles/pairs/pairs.hpp>

#include <cmath>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "support/catch.hpp"

namespace implicit_particles {

using namespace phistep;
using Atoms = Particles<double, 3>;

/// A warm cubic crystal, periodic: 6³ atoms at the distance of the potential's minimum.
inline Atoms crystal(double heat) {
  const double a = std::pow(2.0, 1.0 / 6);
  constexpr int n = 6;
  Eigen::Matrix3Xd r(3, n * n * n);
  for (Index k = 0; k < r.cols(); ++k)
    r.col(k) << static_cast<double>(k % n), static_cast<double>(k / n % n), static_cast<double>(k / (n * n));
  std::srand(1);
  Atoms atoms{a * r, heat * Eigen::Matrix3Xd::Random(3, r.cols())};
  atoms.v.colwise() -= atoms.v.rowwise().mean().eval();
  atoms.set_box(Box<double, 3>::periodic({0, 0, 0}, {n * a, n * a, n * a}));
  return atoms;
}
inline auto argon() { return Pairs{LennardJones{1.0, 1.0}.shifted(2.5), 2.5}; }
template <class Force>
double energy(Force& force, const Atoms& y) {
  const auto masses = Atoms::masses(y);
  return 0.5 * y.v.squaredNorm() + force.energy(0.0, Atoms::view(y, masses));
}

void check_formula(auto scheme, double phi) {
  Atoms atoms = crystal(0.3);
  const Atoms start = atoms;
  constexpr double dt = 0.02;
  PhiStepper stepper{atoms, argon(), scheme};
  REQUIRE(stepper.step(atoms, 0.0, dt));
  Pairs force = argon();
  const auto psi = [&](const Atoms& y) {
    const auto masses = Atoms::masses(y);
    Atoms::Rate out = make_rate<Atoms>(y);
    NeighborMemory memory;
    force.add(0.0, Atoms::view(y, masses), memory, out);
    return out.force;
  };
  const Eigen::Matrix3Xd mean = phi * psi(atoms) + (1 - phi) * psi(start);
  // Newton stops where rounding does: forces are of the order of 1e2.
  CHECK((atoms.v - start.v - dt * mean).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((atoms.r - start.r - dt * start.v - phi * dt * dt * mean).cwiseAbs().maxCoeff() < 1e-13);
}

}  // namespace implicit_particles

using namespace phistep;
using namespace implicit_particles;

#if PHISTEP_FULL

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

#elif PHISTEP_STRESS
// Particles through the implicit solve: with a bonded net, and by backward Euler.

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

#endif
