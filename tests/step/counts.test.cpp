// What a scene doesn't need is not done: exact counts.
#include "step/counts_cases.hpp"
#include "support/shared_force.hpp"

using namespace counts_cases;
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

TEST_CASE("Verlet without velocities: n + 1 force calls for n steps, by integrate and by hand") { check_verlet<Vec>(); }

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

TEST_CASE("a new dt refactorizes, but takes no new Jacobian") { check_new_dt<Vec>(phi(0.5)); }

TEST_CASE("statistics and the step's report count the same iterations") { check_report<Vec>(phi(0.5)); }

namespace {
/// Instantiating any part of a solver with it is an error: proof that φ = 0 doesn't.
struct NoSolver {
  NoSolver() = delete;
};
struct HardErrorJacobian {
  Vec operator()(const Vec& y) const { return -y; }
  template <class V>
  Eigen::MatrixXd jacobian(const V&) const {
    static_assert(!sizeof(V), "a Jacobian was instantiated");
    return {};
  }
};
}  // namespace

TEST_CASE("phi = 0 by type instantiates no solver and no Jacobian") {
  CHECK(by_hand(Vec(1, 1), HardErrorJacobian{}, forward_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian{}, velocity_verlet, newton<NoSolver>()).force_calls == n + 1);
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
  // Stiff decay: with the old factors, corrections shrink by θ = |1 − s·1.25|, s = 2/(1 + 1.25): 1/9; unscaled 1/4.
  const auto iterations = [&](double second_dt) {
    Vec y = Vec::Constant(1e-3);
    PhiStepper stepper{y, stiff, backward_euler, newton({.rtol = 1e-6, .atol = 1e-12})};
    y.setConstant(1.001e-3);
    REQUIRE(stepper.step(y, 0, 1.0));
    y.setConstant(1.001e-3);
    const Statistics before = stepper.statistics();
    const StepReport report = stepper.step(y, 0, second_dt);
    REQUIRE(report);
    CHECK(std::abs(y[0] - 1e-3) <= 1e-9);  // a relative 1e-6
    const Statistics s = stepper.statistics() - before;
    CHECK(s.jacobians == 0);
    CHECK(s.factorizations == (second_dt > 1.3 ? 1 : 0));
    return report.iterations();
  };
  CHECK(iterations(1.0) == 2);
  CHECK(iterations(1.5) == 2);  // new factors of the old Jacobian
  const int kept = iterations(1.25);
  CAPTURE(kept);
  CHECK(kept <= 6);  // 1e5 to go at 1/9 each
}

TEST_CASE("a carried Ψ is Ψ, not M⁻¹Ψ, where the mass is a matrix") {
  const Eigen::Matrix2d M = (Eigen::Matrix2d() << 4, 1, 1, 3).finished();
  const auto check = [&M](auto scheme) {
    Motion<Eigen::Vector2d> a{Eigen::Vector2d(1, -0.5), Eigen::Vector2d(0, 0.3)}, b = a;
    const auto force = [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -3 * r; };
    PhiStepper carries{a, force, scheme, mass(M)};
    for (int n = 0; n < 3; ++n) {
      PhiStepper fresh{b, force, scheme, mass(M)};
      REQUIRE(carries.step(a, 0.1 * n, 0.1));
      REQUIRE(fresh.step(b, 0.1 * n, 0.1));
    }
    CHECK(a.r == b.r);
    CHECK(a.v == b.v);
  };
  check(velocity_verlet);
}
