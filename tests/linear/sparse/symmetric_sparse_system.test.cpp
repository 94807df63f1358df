// Symmetric matrices found by looking, behind steppers. Promised ones: symmetric_sparse_system.full.cpp,
// symmetric_sparse_system_nets.stress.cpp.
#include <phistep/schemes/rodas.hpp>
#include <phistep/sparse.hpp>

#include <string>
#include <utility>

#include "problems/reaction_diffusion.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace problems;
using Vec = Eigen::VectorXd;

namespace {

constexpr double dt = 2e-3;

struct Ended {
  Vec y;
  Statistics counts;
  std::string solver;
};
Ended steps(const ReactionDiffusion& problem, auto force, auto scheme, int count, auto... more) {
  Vec y = problem.start();
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < count; ++k) {
    const StepReport report = stepper.step(y, dt * k, dt);
    INFO(report.message());
    REQUIRE(report);
  }
  return {y, stepper.statistics(), stepper.solver_name()};
}
using Lu = Newton<Eigen::SparseLU<Eigen::SparseMatrix<double>>>;
double apart(const Vec& a, const Vec& b) { return (a - b).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("a field whose Jacobian is symmetric is solved by LDLT, without a promise") {
  const ReactionDiffusion calm{.m = 12};
  const Ended lu = steps(calm, ReactionDiffusionTerm{calm}, trapezoidal, 10, Lu{});
  CHECK(lu.counts.factorizations > 1);
  const auto check = [&](const Ended& found, double tolerance) {
    CHECK(found.solver == "sparse LDLT, found symmetric");
    CHECK(found.counts.fallbacks == 0);
    CHECK(found.counts.analyses == 1);
    CHECK(apart(found.y, lu.y) <= tolerance);
  };
  SECTION("supplied: as with a promise, to the last bit") {
    const Ended found = steps(calm, ReactionDiffusionTerm{calm}, trapezoidal, 10);
    const Ended promised = steps(calm, symmetric(ReactionDiffusionTerm{calm}), trapezoidal, 10);
    check(found, 1e-14);
    CHECK(found.counts.factorizations == lu.counts.factorizations);
    CHECK(found.counts.iterations == lu.counts.iterations);
    CHECK((found.y.array() == promised.y.array()).all());
  }
  SECTION("by differences: iterations make up for what they are off") {
    const Ended found = steps(calm, sparsity(as_function(calm), calm.pattern()), trapezoidal, 10);
    check(found, 1e-14);
    CHECK(found.counts.iterations <= lu.counts.iterations + 2);
  }
  SECTION("linear stages, supplied") {
    const Ended found = steps(calm, ReactionDiffusionTerm{calm}, rodas4, 5);
    const Ended by_lu = steps(calm, ReactionDiffusionTerm{calm}, rodas4, 5, Lu{});
    CHECK(found.solver == "sparse LDLT, found symmetric");
    CHECK(found.counts.factorizations == by_lu.counts.factorizations);
    CHECK(apart(found.y, by_lu.y) <= 1e-14);
  }
}

TEST_CASE("what isn't corrected is not solved by half of a matrix of differences") {
  const ReactionDiffusion calm{.m = 6};
  CHECK(steps(calm, sparsity(as_function(calm), calm.pattern()), rodas4, 2).solver == "sparse LU");
  CHECK(steps(calm, sparsity(as_function(calm), calm.pattern()), trapezoidal, 2, linearly_implicit()).solver ==
        "sparse LU");
}

TEST_CASE("a field with wind has an unsymmetric Jacobian: LU, from the start or from where the wind rises") {
  const ReactionDiffusion windy{.m = 12, .wind = 5}, rising{.m = 12, .wind = 5, .wind_from = 5.5 * dt};
  const auto check = [](const ReactionDiffusion& problem, auto force, int fallbacks, int analyses) {
    const Ended found = steps(problem, force, trapezoidal, 10), lu = steps(problem, force, trapezoidal, 10, Lu{});
    CHECK(found.solver == "sparse LU");
    CHECK(found.counts.fallbacks == fallbacks);
    CHECK(found.counts.analyses == analyses);
    CHECK(apart(found.y, lu.y) <= 1e-14);
    return std::pair{found, lu};
  };
  const auto [found, lu] = check(windy, ReactionDiffusionTerm{windy}, 0, 1);
  CHECK((found.y.array() == lu.y.array()).all());
  CHECK(found.counts.factorizations == lu.counts.factorizations);
  check(windy, sparsity(as_function(windy), windy.pattern()), 0, 1);
  check(rising, ReactionDiffusionTerm{rising}, 1, 2);
  check(rising, sparsity(as_function(rising), rising.pattern()), 1, 2);
}
