// Every outcome, provoked through the public interface; in each case the state keeps every bit.
#include <phistep/phistep.hpp>

#include <cmath>

#include "contract/states.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;
using states::same_bits;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using One = Eigen::Matrix<double, 1, 1>;

namespace outcomes_cases {

/// y' = J y, with a Jacobian of the test's choice.
struct Linear {
  Mat J, claimed;
  Vec operator()(const Vec& y) const { return J * y; }
  Mat jacobian(const Vec&) const { return claimed; }
};
using ByDifferences = shared_force::OfState<Vec>;

/// What is said of a failed step, and that y and the statistics know of it.
inline void check_failed(Outcome expected, const StepReport& report, const Vec& y, const Vec& before,
                         const Statistics& statistics) {
  INFO(report.message());
  CHECK(report.outcome() == expected);
  CHECK(report.failure().outcome == expected);
  CHECK_THAT(report.message(), contains(describe(expected)) && contains(advise(expected)) && contains("dt = 1"));
  CHECK(same_bits(y, before));
  CHECK(statistics.failed_steps == 1);
  CHECK(statistics.steps == 0);
}
/// One step of dt = 1 that must fail so, in message and report alike, and leave y.
template <class F, class... More>
void must_fail(Outcome expected, Vec y, F force, auto scheme, const More&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  const Vec before = y;
  const StepReport report = stepper.step(y, 0, 1);
  check_failed(expected, report, y, before, stepper.statistics());
}

inline Mat identity(int n) { return Mat::Identity(n, n); }

}  // namespace outcomes_cases

#if PHISTEP_QUICK

using namespace outcomes_cases;

TEST_CASE("singular: 1 = φz, by differences, analytic, diagonal, sparse") {
  must_fail(Outcome::singular_matrix, Vec::Ones(1), ByDifferences([](const Vec& y) -> Vec { return y; }),
            backward_euler);
}

TEST_CASE("a Jacobian that is not finite") {
  for (const double bad : {std::nan(""), HUGE_VAL}) {  // beside y, where differences ask
    const ByDifferences edge = [bad](const Vec& y) -> Vec { return y[1] == 1 ? Vec(-y) : Vec(bad * y); };
    must_fail(Outcome::non_finite_jacobian, Vec::Ones(3), edge, backward_euler);
  }
}

TEST_CASE("a jump on first order: stalled, and the message tells the iterations") {
  Vec y = Vec::Constant(1, 0.3);
  PhiStepper stepper{y, ByDifferences([](const Vec& x) -> Vec { return Vec::Constant(1, x[0] > 0 ? -1.0 : 1.0); }),
                     backward_euler, newton({.max_iterations = 5})};
  const StepReport report = stepper.step(y, 0, 1);
  CHECK(report.outcome() == Outcome::newton_stalled);
  CHECK(report.iterations() == 2 * 5);
  CHECK_THAT(report.message(), contains("Newton increments") && contains("smaller dt"));
  CHECK(y[0] == 0.3);
}

TEST_CASE("Newton that diverges says so") {
  // atan, started too far out: the classical example.
  Vec y = Vec::Constant(1, 30.0);
  PhiStepper far{y, ByDifferences([](const Vec& x) -> Vec { return (-1e4 * x.array().atan()).matrix(); }),
                 backward_euler, newton({.rtol = 1e-6, .atol = 1e-6})};
  CHECK(far.step(y, 0, 1).outcome() == Outcome::newton_diverged);
  CHECK(y[0] == 30);
}

TEST_CASE("a very stiff force by differences is solved or refused, never silently wrong") {
  for (const double k : {1e3, 1e6, 1e9, 1e12, 1e15, 1e20}) {
    Vec y = Vec::Ones(1);
    PhiStepper stepper{y, ByDifferences([k](const Vec& x) -> Vec { return -k * x.array().cube(); }), backward_euler};
    const StepReport report = stepper.step(y, 0, 1);
    CAPTURE(k, y[0], report.message());
    if (report) CHECK(y[0] + k * std::pow(y[0], 3) == Approx(1).epsilon(1e-6));
  }
}

TEST_CASE("positions that aren't finite, under a force that doesn't say so") {
  const auto constant = [](const Vec& r) -> Vec { return Vec::Ones(r.size()); };
  const auto fails = [&](const auto& scheme) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1.7e308}) {
      Motion y{Vec{{1.0, bad}}, Vec{{0.0, 1e308}}};
      PhiStepper stepper{y, constant, scheme};
      CAPTURE(bad);
      CHECK(stepper.step(y, 0, 1).outcome() == Outcome::non_finite_state);
    }
  };
  fails(symplectic_euler_adjoint);
  fails(symplectic_euler);
  fails(velocity_verlet);
  fails(phi(1.0, 0.0));
  fails(phi(1.0, 0.3));
}

TEST_CASE("a state that overflows in the update") {
  must_fail(Outcome::non_finite_state, Vec::Constant(2, 1.7e308), ByDifferences([](const Vec& y) -> Vec { return y; }),
            forward_euler);
}

TEST_CASE("two large finite outputs are no overflow") {
  Vec y = Vec::Constant(20, 1e308);
  PhiStepper stepper{y, ByDifferences([](const Vec& x) -> Vec { return Vec::Zero(x.size()); }), forward_euler};
  CHECK(stepper.step(y, 0, 1));
}

TEST_CASE("a step refused for its dt shows no increments of an earlier step") {
  Vec y = Vec::Ones(2);
  PhiStepper stepper{y, ByDifferences([](const Vec& x) -> Vec { return -x; }), backward_euler};
  REQUIRE(stepper.step(y, 0, 0.1));
  const StepReport report = stepper.step(y, 0, std::nan(""));
  CHECK(report.outcome() == Outcome::invalid_step);
  CHECK(report.iterations() == 0);
  CHECK_THAT(report.message(), !contains("increments"));
}

TEST_CASE("Newton's tolerance option keeps its promise on a nonlinear decay") {
  const ByDifferences cubic = [](const Vec& y) -> Vec { return -y.array().cube(); };
  for (const double rtol : {1e-3, 1e-6, 1e-9}) {
    Vec y = Vec::Constant(1, 2.0), exact = y;
    PhiStepper loose{y, cubic, backward_euler, newton({.rtol = rtol, .atol = rtol})};
    PhiStepper tight{exact, cubic, backward_euler};
    REQUIRE(loose.step(y, 0, 0.3));
    REQUIRE(tight.step(exact, 0, 0.3));
    CHECK(std::abs(y[0] - exact[0]) <= rtol);
    CHECK(loose.statistics().iterations <= tight.statistics().iterations);
  }
}

TEST_CASE("failing again and again stays typed") {
  Vec y = Vec::Ones(3);
  PhiStepper stepper{y, ByDifferences([](const Vec& x) -> Vec { return x; }), backward_euler};
  for (int n = 0; n < 5; ++n) CHECK(stepper.step(y, 0, 1).outcome() == Outcome::singular_matrix);
  CHECK(stepper.statistics().failed_steps == 5);
  CHECK(stepper.step(y, 0, 0.5));
}

#elif PHISTEP_FULL

//
#include <phistep/sparse.hpp>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>

namespace {

using Sparse = Eigen::SparseMatrix<double>;

struct SparseLinear {
  Sparse J;
  Vec operator()(const Vec& y) const { return J * y; }
  Sparse jacobian(const Vec&) const { return J; }
};

}  // namespace

using namespace outcomes_cases;

TEST_CASE("singular: 1 = φz, by differences, analytic, diagonal, sparse") {
  must_fail(Outcome::singular_matrix, Vec::Ones(3), Linear{2 * identity(3), 2 * identity(3)}, trapezoidal);
  must_fail(Outcome::singular_matrix, Vec::Ones(1), ByDifferences([](const Vec& y) -> Vec { return y; }),
            backward_euler);
  must_fail(Outcome::singular_matrix, Vec::Ones(2), SparseLinear{Sparse(identity(2).sparseView())}, backward_euler);
  Motion<Vec> y{Vec::Ones(2), Vec::Ones(2)};  // −c v with c < 0: W = 1 + c
  PhiStepper stepper{y, LinearDrag{-1}, backward_euler};
  CHECK(stepper.step(y, 0, 1).outcome() == Outcome::singular_matrix);
  CHECK((y.r == Vec::Ones(2) && y.v == Vec::Ones(2)));
}

TEST_CASE("a Jacobian that is not finite") {
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    Mat claimed = -identity(3);
    claimed(2, 1) = bad;
    must_fail(Outcome::non_finite_jacobian, Vec::Ones(3), Linear{-identity(3), claimed}, trapezoidal);
    must_fail(Outcome::non_finite_jacobian, Vec::Ones(3), Linear{-identity(3), claimed}, midpoint);
  }
}

TEST_CASE("not positive definite, where the solver needs it") {
  const SparseLinear indefinite{Sparse((Vec(3) << -1, 5, -1).finished().asDiagonal().toDenseMatrix().sparseView())};
  must_fail(Outcome::not_positive_definite, Vec::Ones(3), indefinite, backward_euler,
            newton<Eigen::SimplicialLDLT<Sparse>>());
  must_fail(Outcome::not_positive_definite, Vec::Ones(3), indefinite, backward_euler,
            newton<Eigen::SimplicialLLT<Sparse>>());
  Vec y = Vec::Ones(3);  // LU doesn't mind
  CHECK(PhiStepper{y, indefinite, backward_euler}.step(y, 0, 1));
}

TEST_CASE("an iterative solver that gives up") {
  struct OneIteration : Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper> {
    OneIteration() { setMaxIterations(1), setTolerance(1e-14); }
  };
  Mat J = -4 * identity(20);
  for (int i = 0; i + 1 < 20; ++i) J(i, i + 1) = J(i + 1, i) = 1.9;
  must_fail(Outcome::linear_solver_failed, Vec::LinSpaced(20, 0, 1), SparseLinear{Sparse(J.sparseView())},
            backward_euler, newton<OneIteration>());
}

TEST_CASE("conjugate gradients agree with LU where they succeed") {
  Mat J = -4 * identity(20);
  for (int i = 0; i + 1 < 20; ++i) J(i, i + 1) = J(i + 1, i) = 1.9;
  const SparseLinear force{Sparse(J.sparseView())};
  Vec y = Vec::LinSpaced(20, 0, 1), z = y;
  PhiStepper cg{y, force, trapezoidal, newton<Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper>>()};
  PhiStepper lu{z, force, trapezoidal};
  for (int n = 0; n < 10; ++n) REQUIRE((cg.step(y, 0, 0.1) && lu.step(z, 0, 0.1)));
  CHECK((y - z).cwiseAbs().maxCoeff() <= 1e-13);
}

TEST_CASE("Newton cycles on a jump: stalled, at any size of the step") {
  // Friction: v' = −sign(v); backward Euler has no solution for |v| < dt. r is far larger than r moves.
  for (const double dt : {1.0, 1e-3, 1e-6, 1e-9}) {
    Motion<One> y{One(1.0), One(0.3 * dt)};
    PhiStepper stepper{y, [](const One&, const One& v) -> One { return One(v[0] > 0 ? -1.0 : 1.0); }, backward_euler};
    const StepReport report = stepper.step(y, 0, dt);
    CAPTURE(dt, report.message());
    CHECK((report.outcome() == Outcome::newton_stalled || report.outcome() == Outcome::newton_diverged));
    CHECK((y.r[0] == 1 && y.v[0] == 0.3 * dt));
    CHECK(report.iterations() == 2 * 25);
  }
}

TEST_CASE("a Jacobian of the wrong sign: refused, or the right answer; never another") {
  for (const double k : {0.01, 0.1, 1.0, 3.0, 10.0, 1e3, 1e6, 1e12, 1e18}) {
    Vec y = Vec::Constant(2, 1.0);
    PhiStepper stepper{y, Linear{-k * identity(2), 0.9 * k * identity(2)}, backward_euler};
    const StepReport report = stepper.step(y, 0, 1);
    CAPTURE(k, report.message());
    if (report) CHECK(y[0] == Approx(1 / (1 + k)).epsilon(1e-10));
    else CHECK(y[0] == 1);
  }
  Vec y = Vec::Constant(2, 1.0);
  PhiStepper stepper{y, Linear{-10 * identity(2), 10 * identity(2)}, backward_euler,
                     newton({.rtol = 1e-6, .atol = 1e-9})};
  CHECK_FALSE(stepper.step(y, 0, 1));
}

TEST_CASE("Newton that diverges says so") {
  // atan, started too far out: the classical example.
  Vec y = Vec::Constant(1, 30.0);
  PhiStepper far{y, ByDifferences([](const Vec& x) -> Vec { return (-1e4 * x.array().atan()).matrix(); }),
                 backward_euler, newton({.rtol = 1e-6, .atol = 1e-6})};
  CHECK(far.step(y, 0, 1).outcome() == Outcome::newton_diverged);
  CHECK(y[0] == 30);
  // The equation is ∛Y = y: each increment is −2 times the last.
  struct CubeRoot {
    Vec operator()(const Vec& x) const {
      return x - Vec(x.array().unaryExpr([](double a) { return std::cbrt(a); }));
    }
    Mat jacobian(const Vec& x) const { return Mat::Constant(1, 1, 1 - 1 / (3 * std::pow(std::cbrt(x[0]), 2))); }
  };
  y[0] = 1e-3;
  PhiStepper stepper{y, CubeRoot{}, backward_euler};
  const StepReport report = stepper.step(y, 0, 1);
  INFO(report.message());
  CHECK(report.outcome() == Outcome::newton_diverged);
  CHECK(y[0] == 1e-3);
}

TEST_CASE("a state that overflows in the update") {
  must_fail(Outcome::non_finite_state, Vec::Constant(2, 1.7e308), ByDifferences([](const Vec& y) -> Vec { return y; }),
            forward_euler);
  Motion<Vec> y{Vec::Constant(2, 1.7e308), Vec::Constant(2, 1.7e308)};
  PhiStepper stepper{y, [](const Vec& r) -> Vec { return Vec::Zero(r.size()); }, velocity_verlet};
  const StepReport report = stepper.step(y, 0, 1);
  CHECK(report.outcome() == Outcome::non_finite_state);
  CHECK(report.failure().block == 0);
  CHECK(y.r == Vec::Constant(2, 1.7e308));
}

TEST_CASE("a step refused for its dt shows no increments of an earlier step") {
  Vec y = Vec::Ones(2);
  PhiStepper stepper{y, Linear{-identity(2), -identity(2)}, trapezoidal};
  REQUIRE(stepper.step(y, 0, 0.1));
  const StepReport report = stepper.step(y, 0, std::nan(""));
  CHECK(report.outcome() == Outcome::invalid_step);
  CHECK(report.iterations() == 0);
  CHECK_THAT(report.message(), !contains("increments"));
}

TEST_CASE("failing again and again stays typed") {
  Vec y = Vec::Ones(3);
  PhiStepper stepper{y, Linear{2 * identity(3), 2 * identity(3)}, trapezoidal};
  for (int n = 0; n < 5; ++n) CHECK(stepper.step(y, 0, 1).outcome() == Outcome::singular_matrix);
  CHECK(stepper.statistics().failed_steps == 5);
  CHECK(stepper.step(y, 0, 0.5));
}

#endif
