// Large sparse fields, by a direct solver or by Krylov iterations: which, by what count, and what if W turns unsymmetric.
// Affine fields and patterns alone: automatic_fields.stress.
#include <phistep/sparse.hpp>

#include "problems/reaction_diffusion.hpp"
#include "run/choice/automatic_cases.hpp"
#if PHISTEP_FULL
#include <phistep/advise.hpp>

#include "phistep/base/archive/archive.hpp"
#endif
#if PHISTEP_STRESS
#include "problems/heat_2d.hpp"
#endif

using namespace automatic_cases;

#if PHISTEP_FULL

namespace {

using problems::ReactionDiffusion;
using problems::ReactionDiffusionTerm;
using Field = Eigen::VectorXd;
constexpr TimeSpan<double> span{0.0, 1.0};
const tolerance wanted{.rtol = 1e-3, .atol = 1e-5};

using Put = std::function<void(Eigen::Index, Eigen::Index, double)>;
/// Any sparse term, with its Jacobian: one type of force, seven steppers to compile.
struct AnyField : ForceTerm {
  static constexpr Structure structure = Structure::sparse;
  std::function<void(double, const Field&, Field&)> rate;
  std::function<void(double, const Field&, const Put&)> entries;
  template <class Term>
  explicit AnyField(const Term& term)
      : rate{[term](double t, const Field& y, Field& out) {
          const State state{y};
          Out to{out};
          term.add(t, state, to);
        }},
        entries{[term](double t, const Field& y, const Put& put) {
          Sink sink{put};
          term.add_jacobian(t, State{y}, sink);
        }} {}
  void add(double t, const auto& state, auto& out) const { rate(t, state.y, out.rate); }
  void add_jacobian(double t, const auto& state, auto& sink) const {
    entries(t, state.y, [&sink](Eigen::Index i, Eigen::Index j, double x) { sink.rate(i, j, x); });
  }

 private:
  struct State {
    const Field& y;
  };
  struct Out {
    Field& rate;
  };
  struct Sink {
    const Put& put;
    void rate(Eigen::Index i, Eigen::Index j, double x) const { put(i, j, x); }
  };
};

AutomaticReport run(Field& y, const ReactionDiffusion& problem) {
  y = problem.start();
  const AnyField force{ReactionDiffusionTerm{problem}};
  return integrate(y, force, span, wanted);
}
double error(const Field& y, const ReactionDiffusion& problem) {
  Field exact = problem.start();
  REQUIRE(by_hand(exact, AnyField{ReactionDiffusionTerm{problem}}, tsit5, span, {.rtol = 1e-6, .atol = 1e-8}));
  return (y - exact).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("few points: a factorization; many: Krylov iterations; the report says the count") {
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
             contains("rodas4p2 from t = 0.0") && contains("; Krylov iterations, a factorization has at least "));
  CHECK(error(y, cube) < 3e-3);
}

TEST_CASE("the count: one Jacobian, symmetric or not, and the fill; the first step finds the Jacobian") {
  Statistics spent;
  const auto count = [&spent](const ReactionDiffusion& problem) {
    Field y = problem.start();
    const Field weight = Field::Ones(y.size());
    const AnyField force{ReactionDiffusionTerm{problem}};
    PhiStepper stepper{y, std::cref(force), rodas4p2, FieldMatrix<double>::Solver{}};
    AdvisedProblem known;
    known.has_jacobian = true;
    const FieldCounts counts = FieldMatrix<double>::count<Field>(stepper, 0.0, 1e-3, y, {&weight, 1, 1e-3}, known);
    spent = stepper.statistics();
    CHECK(spent.jacobians == 1);
    CHECK(spent.analyses == 0);
    CHECK(spent.factorizations == 0);
    const auto calls = spent.force_calls;
    REQUIRE(stepper.step(y, 0, 1e-3));
    CHECK(stepper.statistics().jacobians == 1);
    CHECK(stepper.statistics().analyses == 1);
    CHECK(stepper.statistics().force_calls == calls + 5);  // of six stages
    return counts;
  };
  const FieldCounts still = count({.m = 20}), windy = count({.m = 20, .wind = 1e-3});
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
  const Advice advice = advise(cube.start(), AnyField{ReactionDiffusionTerm{cube}}, span, wanted);
  CHECK(advice.scheme == "rodas4p2");
  CHECK_THAT(advice.message(), contains("phistep::rodas4p2, phistep::newton<phistep::PreconditionedBySymmetry>()") &&
                                   contains("a factorization would have at least 15 entries of L an unknown"));
}

TEST_CASE(
    "an unsymmetric field is solved by Krylov iterations too, where LU costs more; also where the wind rules, or "
    "begins later") {
  Field y;
  for (const ReactionDiffusion& windy : {ReactionDiffusion{.m = 15, .rate = 400, .wind = 10},
                                         ReactionDiffusion{.m = 14, .dim = 3, .rate = 0, .wind = 10},
                                         ReactionDiffusion{.m = 30, .rate = 400, .wind = 100}}) {
    CAPTURE(windy.m, windy.dim);
    const AutomaticReport report = run(y, windy);
    REQUIRE(report);
    REQUIRE(report.schemes.count() == 2);
    CHECK(report.schemes.list()[1].scheme == SuitableScheme::rodas_4_krylov);
    CHECK(report.statistics.linear_iterations > 5);
    CHECK(error(y, windy) < 3e-3);
  }
  const ReactionDiffusion later{.m = 14, .dim = 3, .rate = 0, .wind = 100, .wind_from = 0.05};
  const AutomaticReport report = run(y, later);
  REQUIRE(report);
  CHECK(report.schemes.list().back().scheme == SuitableScheme::rodas_4_krylov);
  CHECK(report.schemes.count() <= 4);  // with the wind explicit steps are worth a try
  CHECK(error(y, later) < 1e-2);
}

/// Two species on 20 × 20 points of a torus. From t = 0.1 on the first feeds itself and is eaten by the second, faster than it diffuses: the
/// whole decays, but W's diagonal is negative.
struct Eaten : ForceTerm {
  static constexpr Structure structure = Structure::sparse;
  Eigen::Index points = 400;
  [[nodiscard]] static double strength(double t) { return t < 0.1 ? 0 : 2e4; }
  void each(double t, auto&& put) const {
    const double s = strength(t), d = 2e3;
    for (Eigen::Index k = 0; k < points; ++k)
      for (const Eigen::Index own : {2 * k, 2 * k + 1}) {
        const bool first = own == 2 * k;
        put(own, own, -4 * d + (first ? s : -1.5 * s));
        put(own, first ? own + 1 : own - 1, first ? 2 * s : -2 * s);
        for (const Eigen::Index away : {2, 2 * 20, 2 * 380, 2 * 399}) put(own, (own + away) % (2 * points), d);
      }
  }
  void add(double t, const auto& state, auto& out) const {
    each(t, [&](Eigen::Index i, Eigen::Index j, double x) { out.rate[i] += x * state.y[j]; });
    for (Eigen::Index k = 0; k < points; ++k) out.rate[2 * k] += 1000;
  }
  void add_jacobian(double t, const auto&, auto& sink) const {
    each(t, [&](Eigen::Index i, Eigen::Index j, double x) { sink.rate(i, j, x); });
  }
};

TEST_CASE("where Krylov iterations fail, a direct solver takes over at that step, and the report says so") {
  Field y = Field::LinSpaced(800, 0, 1);
  Field exact = y;
  const AnyField eaten{Eaten{}};
  REQUIRE(by_hand(exact, eaten, tsit5, {0.0, 0.2}, {.rtol = 1e-6, .atol = 1e-8}));
  const AutomaticReport report = integrate(y, eaten, {0.0, 0.2}, {.rtol = 1e-3, .atol = 1e-5});
  REQUIRE(report);
  CAPTURE(report.schemes.message());
  const SchemeUse last = report.schemes.list().back();
  CHECK(last.cause == SchemeCause::unsolved);
  CHECK(last.t > 0.1 - 0.01);  // there W turns, within a step; steps that are short enough are still solved
  CHECK(last.t < 0.1 + 0.03);
  CHECK_THAT(report.schemes.message(),
             contains("by a direct solver from t = 0.1") && contains("Krylov iterations failed"));
  CHECK((y - exact).cwiseAbs().maxCoeff() < 1e-2 * exact.cwiseAbs().maxCoeff());
}

TEST_CASE("a field that isn't counted yet is priced as one for Krylov iterations; once it is, by its count") {
  Field y;
  // A factorization of a cube would cost more than all the explicit steps.
  const ReactionDiffusion cube{.m = 20, .dim = 3};
  y = cube.start();
  const AnyField force{ReactionDiffusionTerm{cube}};
  const AutomaticReport cheap = integrate(y, force, span, {.rtol = 1e-4, .atol = 1e-6});
  REQUIRE(cheap);
  CHECK(cheap.schemes.list().back().scheme == SuitableScheme::rodas_4_krylov);
}

TEST_CASE("a checkpoint on conjugate gradients: resumed to the bit") {
  struct Program {
    ReactionDiffusion cube{.m = 14, .dim = 3, .rate = 400};
    Field y = cube.start();
    AnyField force{ReactionDiffusionTerm{cube}};
    AutomaticStepper<Field, std::reference_wrapper<const AnyField>> stepper{y, std::cref(force), 1e-3};
    Run<decltype(stepper), Field, tolerance> run{stepper, y, span, wanted};
  };
  Program first, other;
  for (int k = 0; k < 20; ++k) REQUIRE(first.run.advance());
  Writer out;
  out.save(first.run);
  first.run.forget_unsaved();
  Reader in{out.bytes()};
  in.load(other.run);
  CHECK(other.stepper.scheme() == SuitableScheme::rodas_4_krylov);
  REQUIRE((first.run.finish() && other.run.finish()));
  CHECK(other.y == first.y);
  CHECK(other.stepper.uses().message() == first.stepper.uses().message());
}

#elif PHISTEP_STRESS
// Large sparse fields that are affine and symmetric, or that declare a pattern alone; the others: automatic_fields.test.

using problems::ReactionDiffusion;
using Field = Eigen::VectorXd;

TEST_CASE("for many digits a field's explicit steps at their limit are fewer than an implicit scheme's are worth") {
  using problems::Heat2D;
  for (const double rtol : {1e-3, 1e-6, 1e-9}) {
    Field y = Heat2D::exact(0);
    const auto report = integrate(y, Heat2D{}, {0.0, Heat2D::end}, {.rtol = rtol, .atol = 0.1 * rtol});
    REQUIRE(report);
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

#endif
