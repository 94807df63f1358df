// What a scene doesn't need is not done: exact counts.
#include <phistep/sparse.hpp>

#include <cmath>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Y = Motion<Vec>;

namespace {

constexpr int n = 20;  // steps

/// Calls that really happen, beside those that the statistics claim.
struct Counted {
  int* calls;
  Vec operator()(const Vec& r) const {
    ++*calls;
    return -4 * r;
  }
};
struct CountedDamped {
  int* calls;
  Vec operator()(const Vec& r, const Vec& v) const {
    ++*calls;
    return -4 * r - 0.3 * v;
  }
};
struct WithJacobian : Counted {
  Eigen::MatrixXd jacobian(const Vec& r) const { return -4 * Eigen::MatrixXd::Identity(r.size(), r.size()); }
};

Y start() { return {Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 0.5)}; }

/// n steps by hand.
template <class State, class F, class... More>
Statistics by_hand(State y, F force, auto scheme, const More&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < n; ++k) REQUIRE(stepper.step(y, 0.01 * k, 0.01));
  CHECK(stepper.statistics().steps == n);
  return stepper.statistics();
}
/// n steps by integrate.
template <class State, class F, class... More>
Statistics by_integrate(State y, F force, auto scheme, const More&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  const RunReport report = integrate(stepper, y, {0, 0.01 * n}, fixed(0.01));
  REQUIRE(report);
  CHECK(report.statistics.steps == n);
  return report.statistics;
}

struct Driven {
  static constexpr bool uses_velocity = false;
  void add(double t, const MotionView<Vec, UnitMass>& y, Y::Rate& out) const {
    out.force.array() += std::sin(t) - y.r.array();
  }
};

struct NoTangent : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const MotionView<Vec, UnitMass>& y, Y::Rate& out) const { out.force -= 4 * y.r; }
};

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
  int calls = 0;
  CHECK(by_integrate(start(), Counted{&calls}, velocity_verlet) == Statistics{.steps = n, .force_calls = n + 1});
  CHECK(calls == n + 1);
  calls = 0;
  CHECK(by_hand(start(), Counted{&calls}, velocity_verlet) == Statistics{.steps = n, .force_calls = n + 1});
  CHECK(calls == n + 1);
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

TEST_CASE("a linear scene: one Jacobian and one factorisation a run, at most two solves a step") {
  int calls = 0;
  const auto check = [](const Statistics& s) {
    CHECK(s.jacobians == 1);
    CHECK(s.factorizations == 1);
    CHECK(s.analyses == 0);
    CHECK(s.solves == s.iterations);
    CHECK(s.iterations <= 2 * n + 1);
  };
  check(by_hand(start(), Counted{&calls}, trapezoidal));  // by differences: exact enough to be kept
  check(by_hand(start(), WithJacobian{{&calls}}, trapezoidal));
  check(by_hand(start(), CountedDamped{&calls}, backward_euler));
  check(by_integrate(Vec(Vec::LinSpaced(5, 1, 2)), decay, trapezoidal));
}

TEST_CASE("a new dt refactorises, but takes no new Jacobian") {
  int calls = 0;
  Y y = start();
  PhiStepper stepper{y, WithJacobian{{&calls}}, trapezoidal};
  for (const double dt : {0.1, 0.1, 0.2, 0.2, 0.1}) REQUIRE(stepper.step(y, 0, dt));
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 3);
}

TEST_CASE("sparse heat: one analysis, one Jacobian, one factorisation a run") {
  struct Heat {
    Eigen::SparseMatrix<double> A;
    Vec operator()(const Vec& T) const { return A * T; }
    Eigen::SparseMatrix<double> jacobian(const Vec&) const { return A; }
  };
  constexpr int size = 50;
  Eigen::SparseMatrix<double> A(size, size);
  for (int i = 0; i < size; ++i) {
    A.insert(i, i) = -2;
    if (i > 0) A.insert(i, i - 1) = 1;
    if (i + 1 < size) A.insert(i, i + 1) = 1;
  }
  const Vec T = Vec::LinSpaced(size, 0, 1).array().sin();
  for (const Statistics& s :
       {by_integrate(T, Heat{A}, trapezoidal, capacity(3.0)), by_integrate(T, Heat{A}, backward_euler)}) {
    CHECK(s.analyses == 1);
    CHECK(s.jacobians == 1);
    CHECK(s.factorizations == 1);
  }
}

TEST_CASE("statistics and the step's report count the same iterations") {
  Y y = start();
  int calls = 0;
  PhiStepper stepper{y, WithJacobian{{&calls}}, trapezoidal};
  std::int64_t iterations = 0;
  for (int k = 0; k < 5; ++k) iterations += stepper.step(y, 0, 0.1).iterations();
  CHECK(iterations == stepper.statistics().iterations);
  CHECK(stepper.statistics().force_calls == calls);
}

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
  CHECK(by_hand(Vec(Vec::Ones(3)), HardErrorJacobian{}, forward_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian{}, forward_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian{}, symplectic_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian{}, symplectic_euler_adjoint, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian{}, velocity_verlet, newton<NoSolver>()).force_calls == n + 1);
  CHECK(by_hand(start(), HardErrorJacobian{}, forward_euler, mass(2.0), newton<NoSolver>()).force_calls == n);
}

TEST_CASE("an explicit stepper is as small as its parts") {
  const Eigen::Vector3d y = Eigen::Vector3d::Ones();
  const auto force = [](const Eigen::Vector3d& x) -> Eigen::Vector3d { return -x; };
  PhiStepper explicit_{y, force, forward_euler};
  PhiStepper implicit{y, force, backward_euler};
  CHECK(sizeof(explicit_) + sizeof(Eigen::Matrix3d) < sizeof(implicit));
}

TEST_CASE("first order: the solve starts from the Ψ that the step began with, if Ψ ignores t") {
  struct Decay {
    Vec operator()(const Vec& y) const { return -y.array().cube(); }
    Eigen::MatrixXd jacobian(const Vec& y) const { return (-3 * y.array().square()).matrix().asDiagonal(); }
  };
  struct DecayInTime : Decay {
    Vec operator()(const Vec& y, double) const { return Decay::operator()(y); }
    Eigen::MatrixXd jacobian(const Vec& y, double) const { return Decay::jacobian(y); }
  };
  const Vec y = Vec::LinSpaced(5, 1, 2);
  const Statistics shared = by_hand(y, Decay{}, trapezoidal), apart = by_hand(y, DecayInTime{}, trapezoidal);
  CHECK(shared.iterations == apart.iterations);
  CHECK(shared.force_calls == shared.iterations);
  CHECK(apart.force_calls == apart.iterations + n);
  // Not where a matrix mass has worked in the same place: the answer tells.
  const Eigen::MatrixXd M = 2 * Eigen::MatrixXd::Identity(5, 5);
  Vec a = y, b = y;
  PhiStepper matrix{a, Decay{}, trapezoidal, capacity(M)};
  PhiStepper scalar{b, Decay{}, trapezoidal, capacity(2.0)};
  for (int k = 0; k < n; ++k) {
    REQUIRE(matrix.step(a, 0, 0.1));
    REQUIRE(scalar.step(b, 0, 0.1));
  }
  CHECK((a - b).norm() <= 1e-14);
}

TEST_CASE("to a tolerance, the factors of a step 1.25 times as long serve, and their corrections are scaled") {
  // Stiff decay: with the old factors, corrections shrink by θ = |1 − s·1.25|, s = 2/(1 + 1.25): 1/9; unscaled 1/4.
  const auto iterations = [](double second_dt) {
    Vec y = Vec::Constant(1, 1e-3);
    PhiStepper stepper{y, [](const Vec& x) -> Vec { return -1e8 * (x.array() - 1e-3); }, backward_euler,
                       newton({.rtol = 1e-6, .atol = 1e-12})};
    y[0] = 1.001e-3;
    REQUIRE(stepper.step(y, 0, 1.0));
    y[0] = 1.001e-3;
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
  check(symplectic_euler_adjoint);
  check(phi(0.8, 0));
}
