// Exact counts where sparse matrices, masses and solvers differ; in short: counts.test.cpp.
#include <phistep/sparse.hpp>

#include "run/stepper/counts_cases.hpp"

using namespace counts_cases;
using Vec = Eigen::VectorXd;
using Y = Motion<Vec>;

namespace {

Y start() { return start_of<Vec>(); }

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
  check_kept_factors(Vec(Vec::Ones(1)), [](const Vec& x) -> Vec { return -1e8 * (x.array() - 1e-3); });
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
  check_carried(velocity_verlet);
  check_carried(symplectic_euler_adjoint);
  check_carried(phi(0.8, 0));
}

TEST_CASE("phi = 0 by type instantiates no solver and no Jacobian") {
  CHECK(by_hand(Vec(Vec::Ones(3)), HardErrorJacobian<Vec>{}, forward_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian<Vec>{}, forward_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian<Vec>{}, symplectic_euler, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian<Vec>{}, symplectic_euler_adjoint, newton<NoSolver>()).force_calls == n);
  CHECK(by_hand(start(), HardErrorJacobian<Vec>{}, velocity_verlet, newton<NoSolver>()).force_calls == n + 1);
  CHECK(by_hand(start(), HardErrorJacobian<Vec>{}, forward_euler, mass(2.0), newton<NoSolver>()).force_calls == n);
}
