// Preconditioned Krylov methods behind steppers: answers, orders, errors that follow the tolerance, counts, hooks.
#include <phistep/integrate.hpp>
#include <phistep/krylov.hpp>
#include <phistep/schemes/rosenbrock.hpp>
#include <phistep/sparse.hpp>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "problems/reaction_diffusion.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace problems;
using Vec = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

const ReactionDiffusion calm{.m = 16}, windy{.m = 16, .wind = 5};
constexpr double end = 0.05;

struct Ended {
  Vec y;
  RunReport report;
};
Ended run(const ReactionDiffusion& problem, auto scheme, double rtol, auto solver) {
  Vec y = problem.start();
  PhiStepper stepper{y, ReactionDiffusionTerm{problem}, scheme, solver};
  const auto report = integrate(stepper, y, {0.0, end}, tolerance{.rtol = rtol, .atol = rtol});
  INFO(describe(report.outcome));
  REQUIRE(report);
  return {y, report};
}
double apart(const Vec& a, const Vec& b) { return (a - b).cwiseAbs().maxCoeff(); }
using CgIc = PreconditionedCg<IncompleteCholesky>;
using StabIlu = PreconditionedBicgstab<Eigen::IncompleteLUT<double>>;

/// Keeps what it made for the first γ: divides by 1 + 4 γ scale and nothing else.
struct Told {
  std::shared_ptr<std::vector<double>> gammas = std::make_shared<std::vector<double>>();
  double inverse = 1;
  void factorize(const Sparse& W, double gamma_force, double gamma_drift) {
    gammas->push_back(gamma_force);
    inverse = 1 / W.diagonal().mean();
    if (gamma_drift != gamma_force) gammas->push_back(NAN);
  }
  [[nodiscard]] Vec solve(const Vec& b) const { return inverse * b; }
};
/// y_i' = 1 + i/(n − 1), and a Jacobian of zeros
struct Supply : ForceTerm {
  static constexpr Structure structure = Structure::sparse;
  void add(double, const auto& s, auto& out) const { out.rate += Vec::LinSpaced(s.y.size(), 1, 2); }
  void add_jacobian(double, const auto& s, auto& sink) const {
    for (Eigen::Index i = 0; i < s.y.size(); ++i) sink.rate(i, i, 0.0);
  }
};
/// Eigen's, counted.
struct Counted : Eigen::IncompleteLUT<double> {
  static inline int analyses = 0, factorizations = 0;
  void analyzePattern(const Sparse& W) { ++analyses, Eigen::IncompleteLUT<double>::analyzePattern(W); }
  void factorize(const Sparse& W) { ++factorizations, Eigen::IncompleteLUT<double>::factorize(W); }
};

}  // namespace

TEST_CASE("errors follow the tolerance as with a factorization, scheme by scheme") {
  const auto check = [](const ReactionDiffusion& problem, auto scheme, auto solver) {
    const Vec exact = run(problem, rodas4, 1e-9, newton()).y;
    double first = 0, last = 0;
    for (const double rtol : {1e-3, 1e-4, 1e-5, 1e-6}) {
      const Ended direct = run(problem, scheme, rtol, newton()), krylov = run(problem, scheme, rtol, solver);
      const double error = apart(krylov.y, exact), by_lu = apart(direct.y, exact);
      CAPTURE(rtol, error, by_lu);
      CHECK(error <= 1.5 * by_lu + 0.05 * rtol);
      CHECK(error >= 0.5 * by_lu - 0.05 * rtol);
      if (first == 0) first = error;
      last = error;
      const Statistics &a = krylov.report.statistics, &b = direct.report.statistics;
      CHECK(std::abs(static_cast<double>(a.steps - b.steps)) <= 0.05 * static_cast<double>(b.steps) + 1);
      CHECK(static_cast<double>(a.iterations) <= 1.25 * static_cast<double>(b.iterations) + 8);
      // One for each W where it is Eisenstat's, which costs an iteration or two; elsewhere one serves for several.
      CHECK(a.factorizations <=
            (std::is_same_v<decltype(solver), Newton<PreconditionedBySymmetry>> ? b.jacobians + 2 * b.steps
                                                                                : b.factorizations));
      CHECK(a.linear_iterations > 0);
    }
    CHECK(last < first / 30);
  };
  SECTION("TR-BDF2, conjugate gradients") { check(calm, tr_bdf2, newton<CgIc>()); }
  SECTION("TR-BDF2, GMRES") { check(windy, tr_bdf2, newton<PreconditionedGmres<>>()); }
  SECTION("trapezoidal, BiCGSTAB") { check(windy, trapezoidal, newton<StabIlu>()); }
  SECTION("Rodas4, conjugate gradients") { check(calm, rodas4, newton<CgIc>()); }
  SECTION("TR-BDF2, by symmetry") { check(calm, tr_bdf2, newton<PreconditionedBySymmetry>()); }
  SECTION("Rodas4P2, by symmetry, unsymmetric") { check(windy, rodas4p2, newton<PreconditionedBySymmetry>()); }
  SECTION("Rodas4, GMRES") { check(windy, rodas4, newton<PreconditionedGmres<Eigen::IncompleteLUT<double>>>()); }
}

TEST_CASE("without a tolerance steps are solved to rounding, and orders hold on both sides") {
  const auto steps = [](auto scheme, int count, auto solver) {
    Vec y = windy.start();
    PhiStepper stepper{y, ReactionDiffusionTerm{windy}, scheme, solver};
    for (int k = 0; k < count; ++k) REQUIRE(stepper.step(y, 0, 0.02 / count));
    CHECK(std::string(stepper.solver_name()) ==
          (stepper.statistics().linear_iterations > 0 ? "preconditioned Krylov iterations" : "sparse LU"));
    return y;
  };
  const auto order = [&](auto scheme, auto solver, double tolerance) {
    const Vec a = steps(scheme, 8, solver), b = steps(scheme, 16, solver), c = steps(scheme, 32, solver);
    CHECK(apart(a, steps(scheme, 8, newton())) <= tolerance);
    return std::log2(apart(a, b) / apart(b, c));
  };
  CHECK(std::abs(order(backward_euler, newton<StabIlu>(), 1e-13) - 1) < 0.15);
  CHECK(std::abs(order(trapezoidal, newton<PreconditionedGmres<>>(), 1e-13) - 2) < 0.2);
  CHECK(std::abs(order(rodas4, newton<StabIlu>(), 1e-9) - 4) < 0.6);
}

TEST_CASE("a preconditioner serves for several matrices, and is told of γ where it wants to be") {
  Counted::analyses = Counted::factorizations = 0;
  const Ended often = run(windy, tr_bdf2, 1e-5, newton<PreconditionedGmres<Counted>>());
  CHECK(Counted::analyses == 1);
  CHECK(often.report.statistics.analyses == 1);
  CHECK(Counted::factorizations == often.report.statistics.factorizations);
  CHECK(Counted::factorizations * 5 < often.report.statistics.steps);

  Told told;
  const Ended by_own = run(windy, tr_bdf2, 1e-4, newton(PreconditionedGmres<Told>{told}));
  CHECK(static_cast<std::int64_t>(told.gammas->size()) == by_own.report.statistics.factorizations);
  CHECK(told.gammas->front() > 0);
  CHECK(told.gammas->back() > told.gammas->front());  // Δt has grown
  CHECK(apart(by_own.y, run(windy, tr_bdf2, 1e-4, newton()).y) <= 1e-4);
}

TEST_CASE(
    "Rosenbrock's stages begin where the first one puts them: of a force that stays as it is, only that one is "
    "sought") {
  const auto check = [](auto scheme) {
    Vec y = Vec::Zero(50);
    PhiStepper stepper{y, Supply{}, scheme, newton<PreconditionedCg<>>()};
    const auto report = integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-6, .atol = 1e-6});
    REQUIRE(report);
    CHECK((y - Vec::LinSpaced(50, 1, 2)).cwiseAbs().maxCoeff() <= 1e-12);
    CHECK(report.statistics.linear_iterations == report.statistics.steps);
  };
  check(rodas4);
  check(rodas4p2);
  check(rodas5p);
}

TEST_CASE("what can't be solved is an outcome, and nothing moves") {
  Vec y = calm.start();
  const Vec before = y;
  // W = 1 − γ J with J's reaction far above its diffusion is indefinite.
  const ReactionDiffusion hot{.m = 6, .rate = 1e6};
  y = hot.start();
  const Vec start = y;
  PhiStepper stepper{y, ReactionDiffusionTerm{hot}, backward_euler, newton<PreconditionedCg<>>()};
  const StepReport report = stepper.step(y, 0, 0.1);
  CHECK_FALSE(report);
  CHECK((y.array() == start.array()).all());
}

TEST_CASE("a copy of a stepper takes the same steps") {
  Vec y = windy.start();
  PhiStepper stepper{y, ReactionDiffusionTerm{windy}, tr_bdf2, newton<StabIlu>()};
  REQUIRE(stepper.step(y, 0, 1e-3));
  auto copy = stepper;
  Vec z = y;
  REQUIRE(stepper.step(y, 1e-3, 1e-3));
  REQUIRE(copy.step(z, 1e-3, 1e-3));
  CHECK(apart(y, z) <= 1e-13);
}
