// Every outcome, provoked through the public interface; in each case the state keeps every bit.
#include "failure/outcomes_cases.hpp"

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
