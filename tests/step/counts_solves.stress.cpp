// Exact counts where sparse matrices, masses and solvers differ; the quick half is counts.test.cpp.
#include <phistep/sparse.hpp>

#include "step/counts_cases.hpp"

using namespace counts_cases;
using Vec = Eigen::VectorXd;
using Y = Motion<Vec>;

namespace {

Y start() { return start_of<Vec>(); }
const auto decay = [](const Vec& y) -> Vec { return -y; };

}  // namespace

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

TEST_CASE("sparse heat: one analysis, one Jacobian, one factorization a run") {
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
TEST_CASE("phi = 0 by type instantiates no solver and no Jacobian") {
  CHECK(by_hand(Vec(Vec::Ones(3)), HardErrorJacobian{}, forward_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian{}, forward_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian{}, symplectic_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian{}, symplectic_euler_adjoint, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian{}, velocity_verlet, newton<NoSolver>()).force_calls == n + 1);
  CHECK(by_hand(start(), HardErrorJacobian{}, forward_euler, mass(2.0), newton<NoSolver>()).force_calls == n);
}
