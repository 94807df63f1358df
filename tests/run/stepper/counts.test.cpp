// What a scene doesn't need is not done: exact counts.
#include "run/stepper/counts_cases.hpp"
#if PHISTEP_QUICK
#include "support/shared_force.hpp"
#endif

using namespace counts_cases;

#if PHISTEP_QUICK

// Of a fixed size: LU of a dynamic matrix costs seconds to compile.
using Vec = Eigen::Vector2d;
using Y = Motion<Vec>;

namespace {

Y start() { return start_of<Vec>(); }
const shared_force::OfState<Vec> decay = [](const Vec& y) -> Vec { return -y; };

}  // namespace

TEST_CASE("forward and symplectic Euler: one force call a step, no Jacobian, no solve") {
  int calls = 0;
  CHECK(by_hand(start(), CountedDamped{&calls}, symplectic_euler) == Statistics{.steps = n, .force_calls = n});
  CHECK(calls == n);
  CHECK(by_hand(Vec(1, 1), decay, forward_euler) == Statistics{.steps = n, .force_calls = n});
}

TEST_CASE("Verlet without velocities: n + 1 force calls for n steps, by integrate and by hand") {
  check_verlet(start());
}

TEST_CASE("Verlet with masses, and with a time that the force uses") {
  CHECK(by_hand(start(), Driven{}, velocity_verlet).force_calls == n + 1);
}

TEST_CASE("an observer that only looks doesn't cost force calls") {
  int calls = 0;
  Y y = start();
  PhiStepper stepper{y, Counted{&calls}, velocity_verlet};
  REQUIRE(integrate(stepper, y, {0, 0.01 * n}, fixed(0.01), [](double, const Y&) {}));
  CHECK(calls == n + 1);
}

TEST_CASE("Verlet with drag solves for v alone: no tangent of what ignores v") {
  const Statistics s = by_hand(start(), NoTangent{} + LinearDrag{0.3}, velocity_verlet);
  CHECK(s.jacobians == 1);
  CHECK(s.factorizations == 1);
  CHECK(s.force_calls == n + s.iterations);  // none for differences
}

TEST_CASE("a pair (phi, 0) without velocities: no solver is asked") {
  int calls = 0;
  CHECK(by_hand(start(), Counted{&calls}, phi(1.0, 0.0)) == Statistics{.steps = n, .force_calls = n});
  CHECK(by_hand(start(), Counted{&calls}, phi(0.5, 0.0)) == Statistics{.steps = n, .force_calls = 2 * n});
  CHECK(by_hand(start(), Counted{&calls}, phi(0.0, 1.0)) == Statistics{.steps = n, .force_calls = n});
}

TEST_CASE("phi = 0 at run time: neither Jacobian nor solve") {
  int calls = 0;
  CHECK(by_hand(start(), WithJacobian{{&calls}}, phi(0.0)) == Statistics{.steps = n, .force_calls = n});
}

TEST_CASE("backward Euler and the stage form need no force at the start of a step") {
  int calls = 0;
  const Statistics s = by_hand(start(), WithJacobian{{&calls}}, backward_euler);
  CHECK(s.force_calls == s.iterations);
  CHECK(s.jacobians == 1);
  CHECK(s.factorizations == 1);
}

TEST_CASE("phi > 1/2 in endpoint form reuses the force at the end of the last step") {
  int calls = 0;
  const Statistics carried = by_hand(start(), WithJacobian{{&calls}}, phi(0.7));
  CHECK(carried.force_calls == 1 + carried.iterations);
  for (const double p : {0.3, 0.5}) {
    const Statistics s = by_hand(start(), WithJacobian{{&calls}}, phi(p));
    CHECK(s.force_calls == n + s.iterations);
  }
}

TEST_CASE("a linear scene: one Jacobian and one factorization a run, at most two solves a step") {
  int calls = 0;
  check_linear(by_hand(start(), WithJacobian{{&calls}}, phi(0.5)));
  check_linear(by_hand(start(), WithJacobian{{&calls}}, backward_euler));
  check_linear(by_hand(Vec(1, 2), decay, backward_euler));  // by differences: exact enough to be kept
}

TEST_CASE("a new dt refactorizes, but takes no new Jacobian") { check_new_dt(start(), phi(0.5)); }

TEST_CASE("statistics and the step's report count the same iterations") { check_reports(start(), phi(0.5)); }

TEST_CASE("phi = 0 by type instantiates no solver and no Jacobian") {
  CHECK(by_hand(Vec(1, 1), HardErrorJacobian<Vec>{}, forward_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian<Vec>{}, velocity_verlet, newton<NoSolver>()).force_calls == n + 1);
}

TEST_CASE("an explicit stepper is as small as its parts") {
  const Eigen::Vector3d y = Eigen::Vector3d::Ones();
  const auto force = [](const Eigen::Vector3d& x) -> Eigen::Vector3d { return -x; };
  using Explicit = decltype(PhiStepper{y, force, forward_euler});  // no member of it is instantiated
  using Implicit = decltype(PhiStepper{y, force, backward_euler});
  CHECK(sizeof(Explicit) + sizeof(Eigen::Matrix3d) < sizeof(Implicit));
}

TEST_CASE("first order: the solve starts from the Ψ that the step began with, if Ψ ignores t") {
  struct Decay {
    Vec operator()(const Vec& y) const { return -y.array().cube(); }
    Eigen::Matrix2d jacobian(const Vec& y) const { return (-3 * y.array().square()).matrix().asDiagonal(); }
  };
  const Statistics shared = by_hand(Vec(1, 2), Decay{}, trapezoidal);
  CHECK(shared.force_calls == shared.iterations);
}

TEST_CASE("to a tolerance, the factors of a step 1.25 times as long serve, and their corrections are scaled") {
  const shared_force::OfState<Vec> stiff = [](const Vec& x) -> Vec { return -1e8 * (x.array() - 1e-3); };
  check_kept_factors(Vec(1, 1), stiff);
}

TEST_CASE("a carried Ψ is Ψ, not M⁻¹Ψ, where the mass is a matrix") { check_carried(velocity_verlet); }

#elif PHISTEP_FULL
// Exact counts, the whole matrix of states, forces and schemes.

using Vec = Eigen::VectorXd;
using Y = Motion<Vec>;

namespace {

Y start() { return start_of<Vec>(); }
const auto decay = [](const Vec& y) -> Vec { return -y; };

}  // namespace

TEST_CASE("forward and symplectic Euler: one force call a step, no Jacobian, no solve") {
  CHECK(by_hand(
            start(), [](const Vec& r) -> Vec { return -r; }, forward_euler) ==
        Statistics{.steps = n, .force_calls = n});
  int calls = 0;
  CHECK(by_hand(start(), CountedDamped{&calls}, symplectic_euler) == Statistics{.steps = n, .force_calls = n});
  CHECK(calls == n);
  CHECK(by_hand(Vec(Vec::Ones(3)), decay, forward_euler) == Statistics{.steps = n, .force_calls = n});
  CHECK(by_hand(start(), Counted{&calls}, symplectic_euler_adjoint) == Statistics{.steps = n, .force_calls = n});
}

TEST_CASE("Verlet without velocities: n + 1 force calls for n steps, by integrate and by hand") {
  check_verlet(start());
  const Motion<Eigen::Vector2d> fixed_size{Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)};
  const auto pull = [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r; };
  CHECK(by_hand(fixed_size, pull, velocity_verlet).force_calls == n + 1);
  CHECK(by_integrate(fixed_size, pull, velocity_verlet).force_calls == n + 1);
}

TEST_CASE("Verlet with a force that returns a reference: n + 1 calls too") {
  Vec kept;
  const auto force = [&kept](const Vec& r) -> const Vec& { return kept = -4 * r; };
  CHECK(by_integrate(start(), force, velocity_verlet).force_calls == n + 1);
  CHECK(by_hand(start(), force, velocity_verlet).force_calls == n + 1);
}

TEST_CASE("Verlet with masses, and with a time that the force uses") {
  int calls = 0;
  CHECK(by_integrate(start(), Counted{&calls}, velocity_verlet, mass(2.0)).force_calls == n + 1);
  CHECK(by_integrate(start(), Counted{&calls}, velocity_verlet, mass(Eigen::Vector2d(1, 2))).force_calls == n + 1);
  CHECK(by_integrate(start(), Driven{}, velocity_verlet).force_calls == n + 1);
  CHECK(by_hand(start(), Driven{}, velocity_verlet).force_calls == n + 1);
}

TEST_CASE("phi = 0 at run time: neither Jacobian nor solve") {
  int calls = 0;
  CHECK(by_hand(start(), Counted{&calls}, phi(0.0)) == Statistics{.steps = n, .force_calls = n});
  CHECK(by_hand(start(), Counted{&calls}, phi_stage(0.0)) == Statistics{.steps = n, .force_calls = n});
  CHECK(by_hand(Vec(Vec::Ones(3)), decay, phi(0.0)) == Statistics{.steps = n, .force_calls = n});
}

TEST_CASE("backward Euler and the stage form need no force at the start of a step") {
  int calls = 0;
  for (const Statistics& s :
       {by_hand(start(), WithJacobian{{&calls}}, backward_euler), by_hand(start(), WithJacobian{{&calls}}, midpoint),
        by_hand(start(), WithJacobian{{&calls}}, phi_stage(0.7))}) {
    CHECK(s.force_calls == s.iterations);
    CHECK(s.jacobians == 1);
    CHECK(s.factorizations == 1);
  }
  const Statistics trapezoid = by_hand(start(), WithJacobian{{&calls}}, trapezoidal);
  CHECK(trapezoid.force_calls == n + trapezoid.iterations);  // ½ doesn't reuse: an error in Ψ would not die out
}

TEST_CASE("phi > 1/2 in endpoint form reuses the force at the end of the last step") {
  int calls = 0;
  for (const Statistics& s :
       {by_hand(start(), WithJacobian{{&calls}}, phi(0.7)), by_integrate(start(), WithJacobian{{&calls}}, phi(0.7))})
    CHECK(s.force_calls == 1 + s.iterations);
  for (const double p : {0.3, 0.5}) {
    const Statistics s = by_hand(start(), WithJacobian{{&calls}}, phi(p));
    CHECK(s.force_calls == n + s.iterations);
  }
}

TEST_CASE("a linear scene: one Jacobian and one factorization a run, at most two solves a step") {
  int calls = 0;
  check_linear(by_hand(start(), Counted{&calls}, trapezoidal));  // by differences: exact enough to be kept
  check_linear(by_hand(start(), WithJacobian{{&calls}}, trapezoidal));
  check_linear(by_hand(start(), CountedDamped{&calls}, backward_euler));
  check_linear(by_integrate(Vec(Vec::LinSpaced(5, 1, 2)), decay, trapezoidal));
}

TEST_CASE("a new dt refactorizes, but takes no new Jacobian") { check_new_dt(start(), trapezoidal); }

TEST_CASE("statistics and the step's report count the same iterations") { check_reports(start(), trapezoidal); }

#endif
