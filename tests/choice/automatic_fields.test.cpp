// Large sparse fields, by a direct solver or by conjugate gradients: which, by what count, and what if W turns unsymmetric.
#include "choice/automatic_cases.hpp"

#include <phistep/advise.hpp>
#include <phistep/sparse.hpp>

#include "phistep/archive/archive.hpp"
#include "problems/reaction_diffusion.hpp"

using namespace automatic_cases;

namespace {

using problems::ReactionDiffusion;
using problems::ReactionDiffusionTerm;
using Field = Eigen::VectorXd;
constexpr TimeSpan<double> span{0.0, 1.0};
const tolerance wanted{.rtol = 1e-3, .atol = 1e-5};

AutomaticReport run(Field& y, const ReactionDiffusion& problem) {
  y = problem.start();
  return integrate(y, ReactionDiffusionTerm{problem}, span, wanted);
}
double error(const Field& y, const ReactionDiffusion& problem) {
  Field exact = problem.start();
  REQUIRE(by_hand(exact, ReactionDiffusionTerm{problem}, tsit5, span, {.rtol = 1e-6, .atol = 1e-8}));
  return (y - exact).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("few points: a factorization; many: conjugate gradients; the report says the count") {
  Field y;
  const AutomaticReport few = run(y, {.m = 15, .rate = 400});
  REQUIRE(few);
  CHECK(few.schemes.list().back().scheme == SuitableScheme::rodas_5p);
  CHECK(few.statistics.linear_iterations == 0);
  CHECK_THAT(few.schemes.message(),
             contains("; direct solver, a factorization has ") && contains(" entries of L an unknown"));
  CHECK(error(y, {.m = 15, .rate = 400}) < 3e-3);

  const ReactionDiffusion cube{.m = 14, .dim = 3, .rate = 400};
  const AutomaticReport many = run(y, cube);
  REQUIRE(many);
  REQUIRE(many.schemes.count() == 2);
  const SchemeUse use = many.schemes.list()[1];
  CHECK(use.scheme == SuitableScheme::rodas_4_krylov);
  CHECK(use.entries == factor_cost(neighbourhood(cube.pattern(), 512)).entries_an_unknown());
  CHECK(many.statistics.linear_iterations > 10);
  CHECK_THAT(many.schemes.message(),
             contains("rodas4p2 from t = 0.0") && contains("; conjugate gradients, a factorization has at least "));
  CHECK(error(y, cube) < 3e-3);
}

TEST_CASE("the look: one Jacobian, symmetric or not, and the fill") {
  const auto look = [](const ReactionDiffusion& problem, Statistics& spent) {
    return FieldMatrix<double>::look<Field>(ReactionDiffusionTerm{problem}, UnitMasses{}, 0.0, problem.start(), {},
                                            spent);
  };
  Statistics spent;
  const FieldCounts still = look({.m = 20}, spent), windy = look({.m = 20, .wind = 1e-3}, spent);
  CHECK(spent.jacobians == 2);
  CHECK(spent.force_calls == 0);
  CHECK(spent.factorizations == 0);
  CHECK(still.is_symmetric);
  CHECK_FALSE(windy.is_symmetric);
  const FactorCost cost = factor_cost(ReactionDiffusion{.m = 20}.pattern());
  CHECK(still.entries == cost.entries_an_unknown());
  CHECK(still.products == cost.products_an_unknown());
  CHECK(still.row == Approx(5 - 4.0 / 20));
  CHECK(windy.entries == still.entries);
}

TEST_CASE("advise names the solver, and the counts that speak for it") {
  const ReactionDiffusion cube{.m = 14, .dim = 3, .rate = 400};
  const Advice advice = advise(cube.start(), ReactionDiffusionTerm{cube}, span, wanted);
  CHECK(advice.scheme == "rodas4p2");
  CHECK_THAT(advice.message(), contains("phistep::rodas4p2, phistep::newton<phistep::PreconditionedCg<") &&
                                   contains("a factorization would have at least 15 entries of L an unknown"));
}

TEST_CASE("an unsymmetric field takes a factorization, at once or when it becomes one") {
  Field y;
  const ReactionDiffusion windy{.m = 15, .rate = 0, .wind = 10};
  const AutomaticReport always = run(y, windy);
  REQUIRE(always);
  CHECK(always.schemes.list().back().scheme == SuitableScheme::rodas_5p);
  CHECK(error(y, windy) < 3e-3);

  const ReactionDiffusion later{.m = 14, .dim = 3, .rate = 0, .wind = 100, .wind_from = 0.05};
  const AutomaticReport report = run(y, later);
  REQUIRE(report);
  const SchemeUse last = report.schemes.list().back();
  CHECK(last.cause == SchemeCause::unsolved);
  CHECK(last.t == Approx(0.05).epsilon(0.1));
  CHECK_THAT(report.schemes.message(),
             contains("rodas5p by a direct solver from t = 0.0") && contains("conjugate gradients failed"));
  CHECK(error(y, later) < 1e-2);
}

TEST_CASE("a field that isn't counted yet is priced as one for conjugate gradients; once it is, by its count") {
  Field y;
  // A factorization of a cube would cost more than all the explicit steps.
  const ReactionDiffusion cube{.m = 20, .dim = 3};
  y = cube.start();
  const AutomaticReport cheap = integrate(y, ReactionDiffusionTerm{cube}, {0.0, 0.1}, {.rtol = 1e-4, .atol = 1e-6});
  REQUIRE(cheap);
  CHECK(cheap.schemes.list().back().scheme == SuitableScheme::rodas_4_krylov);

  const ReactionDiffusion windy{.m = 14, .dim = 3, .rate = 0, .wind = 10};
  const AutomaticReport dear = run(y, windy);
  REQUIRE(dear);
  CHECK(dear.schemes.count() == 1);
  CHECK(dear.statistics.jacobians == 1);
  CHECK(error(y, windy) < 3e-3);
}

TEST_CASE("a pattern alone: its Jacobian by differences is symmetric to their accuracy") {
  const ReactionDiffusion cube{.m = 14, .dim = 3, .rate = 400};
  Field y = cube.start();
  const auto report = integrate(y, sparsity(problems::as_function(cube), cube.pattern()), span, wanted);
  REQUIRE(report);
  CHECK(report.schemes.list().back().scheme == SuitableScheme::rodas_4_krylov);
  CHECK(error(y, cube) < 3e-3);
}

TEST_CASE("a checkpoint on conjugate gradients: resumed to the bit") {
  struct Program {
    ReactionDiffusion cube{.m = 14, .dim = 3, .rate = 400};
    Field y = cube.start();
    AutomaticStepper<Field, ReactionDiffusionTerm> stepper{y, ReactionDiffusionTerm{cube}, 1e-3};
    Run<decltype(stepper), Field, tolerance> run{stepper, y, span, wanted};
  };
  Program first, other;
  for (int k = 0; k < 12; ++k) REQUIRE(first.run.advance());
  Writer out;
  first.run.save(out);
  first.run.forget_unsaved();
  Reader in{out.bytes()};
  other.run.load(in, [] {});
  CHECK(other.stepper.scheme() == SuitableScheme::rodas_4_krylov);
  REQUIRE((first.run.finish() && other.run.finish()));
  CHECK(other.y == first.y);
  CHECK(other.stepper.uses().message() == first.stepper.uses().message());
}
