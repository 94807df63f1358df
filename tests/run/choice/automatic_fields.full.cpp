// Large sparse fields that are affine and symmetric, or that declare a pattern alone; the others: automatic_fields.test.
#include "run/choice/automatic_cases.hpp"

#include <phistep/sparse.hpp>

#include "problems/heat_2d.hpp"
#include "problems/reaction_diffusion.hpp"

using namespace automatic_cases;
using problems::ReactionDiffusion;
using Field = Eigen::VectorXd;

TEST_CASE("for many digits a field's explicit steps at their limit are fewer than an implicit scheme's are worth") {
  using problems::Heat2D;
  for (const double rtol : {1e-3, 1e-6, 1e-9}) {
    Field y = Heat2D::exact(0);
    const auto report = integrate(y, Heat2D{}, {0.0, Heat2D::end}, {.rtol = rtol, .atol = 0.1 * rtol});
    REQUIRE(report);
    CAPTURE(report.schemes.message());
    CHECK((y - Heat2D::exact(Heat2D::end)).cwiseAbs().maxCoeff() < rtol);
    if (rtol == 1e-3) {
      REQUIRE(report.schemes.count() == 2);
      CHECK(report.schemes.list()[1].scheme == SuitableScheme::rodas_4_krylov);
      CHECK(report.statistics.steps < 50);  // dop853: 260
    } else {
      CHECK(report.schemes.count() == 1);
      CHECK(report.schemes.list()[0].scheme == SuitableScheme::dormand_prince_8);
      CHECK(report.statistics.jacobians == (rtol == 1e-6 ? 1 : 0));  // counted once, near the limit
      CHECK(report.statistics.factorizations == 0);
    }
  }
}

TEST_CASE("a pattern alone: its Jacobian by differences is symmetric to their accuracy") {
  const ReactionDiffusion cube{.m = 14, .dim = 3, .rate = 400};
  Field y = cube.start();
  const auto report =
      integrate(y, sparsity(problems::as_function(cube), cube.pattern()), {0.0, 1.0}, {.rtol = 1e-3, .atol = 1e-5});
  REQUIRE(report);
  CHECK(report.schemes.list().back().scheme == SuitableScheme::rodas_4_krylov);
  Field exact = cube.start();
  REQUIRE(by_hand(exact, problems::as_function(cube), tsit5, {0.0, 1.0}, {.rtol = 1e-6, .atol = 1e-8}));
  CHECK((y - exact).cwiseAbs().maxCoeff() < 3e-3);
}
