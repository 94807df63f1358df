// Exact counts, the whole matrix of states, forces and schemes; the quick half is counts.test.cpp.
#include "run/stepper/counts_cases.hpp"

using namespace counts_cases;
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
