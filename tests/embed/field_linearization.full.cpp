// Fields under the library's schemes: the steps, the calls and the digits of Eigen's vectors.
#include "embed/field_cases.hpp"
#include "support/catch.hpp"

#include <string>
#include <vector>

using namespace phistep;
using fields::Diagonal;

namespace {
Eigen::VectorXd eigen(const LocalField& y) {
  return Eigen::Map<const Eigen::VectorXd>(numbers(y).data(), static_cast<Eigen::Index>(numbers(y).size()));
}
/// A run of the decay both ways, with the same control, or with that of the vectors.
void compare_decay(const auto& scheme, const auto& control, double difference, const auto& of_vectors) {
  LocalField y = local_field({1, 2, 3});
  PhiStepper stepper{y, fields::Decay{}, scheme, newton(Diagonal{})};
  const RunReport report = integrate(stepper, y, {0.0, 1.0}, control);
  Eigen::VectorXd z{{1, 2, 3}};
  PhiStepper like{z, fields::DecayOfVectors{}, scheme, newton()};
  const RunReport expected = integrate(like, z, {0.0, 1.0}, of_vectors);
  REQUIRE(report);
  CHECK(report.statistics.steps == expected.statistics.steps);
  CHECK(report.statistics.rejections == expected.statistics.rejections);
  CHECK(report.statistics.force_calls <= expected.statistics.force_calls + expected.statistics.steps + 1);
  CHECK((eigen(y) - z).lpNorm<Eigen::Infinity>() <= difference);
}
void compare_decay(const auto& scheme, const auto& control, double difference) {
  compare_decay(scheme, control, difference, control);
}
/// … and of swings, with an event and samples inside of steps.
template <class Field, class Vector>
void compare_swings(const Field& force, const Vector& like, const auto& scheme, const auto& control,
                    double difference) {
  const std::vector<double> times{0.31, 1.3};
  std::vector<double> samples, expected_samples;
  Motion<LocalField> y{local_field({1, 2, 3}), local_field({0, 0, 0})};
  PhiStepper stepper{y, force, scheme, mass(2.0), newton(Diagonal{2.0})};
  const RunReport report = integrate(
      stepper, y, {0.0, 3.0}, control, event([](double, const Motion<LocalField>& at) { return numbers(at.r)[0]; }),
      at_times(times, [&](double, const auto& at) { samples.push_back(numbers(at.r)[1]); }));
  Motion<Eigen::VectorXd> z{Eigen::VectorXd{{1, 2, 3}}, Eigen::VectorXd{{0, 0, 0}}};
  PhiStepper reference{z, like, scheme, mass(2.0)};
  const RunReport expected =
      integrate(reference, z, {0.0, 3.0}, control, event([](double, const auto& at) { return at.r[0]; }),
                at_times(times, [&](double, const auto& at) { expected_samples.push_back(at.r[1]); }));
  REQUIRE(report);
  CHECK(report.statistics.steps == expected.statistics.steps);
  CHECK((eigen(y.r) - z.r).lpNorm<Eigen::Infinity>() <= difference);
  CHECK((eigen(y.v) - z.v).lpNorm<Eigen::Infinity>() <= difference);
  REQUIRE(samples.size() == expected_samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) CHECK(std::abs(samples[k] - expected_samples[k]) <= difference);
}
const auto swings = [](const Eigen::VectorXd& r) {
  Eigen::VectorXd out(r.size());
  for (Eigen::Index i = 0; i < r.size(); ++i) out[i] = fields::pull(static_cast<std::size_t>(i), r[i]);
  return out;
};
const auto damped = [](const Eigen::VectorXd& r, const Eigen::VectorXd& v) {
  return Eigen::VectorXd(swings(r) - 0.1 * v);
};
}  // namespace

TEST_CASE("first-order fields take the steps of Eigen's vectors") {
  const tolerance control{.rtol = 1e-4, .atol = 1e-5};
  compare_decay(forward_euler, control, 1e-13);
  compare_decay(trapezoidal, control, 1e-8);
  compare_decay(backward_euler, tolerance{.rtol = 1e-2, .atol = 1e-2}, 1e-6);
  compare_decay(tr_bdf2, control, 1e-8);
  compare_decay(rodas4, control, 1e-13);
  compare_decay(rodas5p, control, 1e-13);
  compare_decay(tsit5, control, 1e-13);
  compare_decay(dop853, control, 1e-13);
}
TEST_CASE("… at a step of their own, to rounding") {
  compare_decay(forward_euler, fixed(0.01), 1e-14);
  compare_decay(phi(0.3), fixed(0.01), 1e-14);
  compare_decay(trapezoidal, fixed(0.1), 1e-13);
  compare_decay(backward_euler, fixed(0.1), 1e-13);
  compare_decay(tr_bdf2, fixed(0.1), 1e-13);
  compare_decay(generalized_alpha(0.5), fixed(0.1), 1e-13);
  compare_decay(rodas5p, fixed(0.1), 1e-13);
}
TEST_CASE("automatic absolute tolerances of a field are those of a block") {
  LocalField y = local_field({1, 2, 3});
  PhiStepper stepper{y, fields::Decay{}, rodas4, newton(Diagonal{})};
  CHECK(integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-4}));
  CHECK(integrate(stepper, y, {0.0, 1.0}, tolerance{.norm = Norm::particle}).outcome == Outcome::invalid_tolerance);
}
TEST_CASE("a field of absolute tolerances asks for what a vector of them does") {
  const std::vector<double> each{1e-5, 1e-3, 1e-7};
  const tolerance control{.rtol = 1e-4, .atol = local_field(each)}, like{.rtol = 1e-4, .atol = each};
  compare_decay(tr_bdf2, control, 1e-8, like);
  compare_decay(rodas4, control, 1e-13, like);
  compare_decay(tsit5, control, 1e-13, like);
  compare_decay(rodas4, tolerance{.rtol = 1e-4, .atol = local_field({0, 1e-3, 0})}, 1e-13,
                tolerance{.rtol = 1e-4, .atol = std::vector<double>{0, 1e-3, 0}});

  const auto refused = [](const AbsoluteTolerance& atol) {
    LocalField y = local_field({1, 2, 3});
    PhiStepper stepper{y, fields::Decay{}, rodas4, newton(Diagonal{})};
    return integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-4, .atol = atol}).outcome;
  };
  CHECK(refused(local_field({1, 1, 1})) == Outcome::success);
  for (const auto& wrong : {std::vector<double>{1, 1}, {1, -1, 1}, {1, std::nan(""), 1}, {1, INFINITY, 1}})
    CHECK(refused(local_field(wrong)) == Outcome::invalid_tolerance);
  CHECK(refused(LocalField{}) == Outcome::invalid_tolerance);
  CHECK(refused(Motion<LocalField>{local_field({1, 1, 1}), local_field({1, 1, 1})}) == Outcome::invalid_tolerance);
  CHECK(refused(each) == Outcome::invalid_tolerance);

  using Motions = Motion<LocalField>;
  Motions y{local_field({1, 2, 3}), local_field({0, 0, 0})};
  Motion<Eigen::VectorXd> z{Eigen::VectorXd{{1, 2, 3}}, Eigen::VectorXd{{0, 0, 0}}};
  PhiStepper fields_of{y, fields::DampedSwings{}, tsit5};
  PhiStepper vectors{z, damped, tsit5};
  const RunReport report =
      integrate(fields_of, y, {0.0, 3.0},
                tolerance{.rtol = 1e-5, .atol = Motions{local_field(each), local_field({1e-2, 1e-2, 1e-2})}});
  const RunReport expected = integrate(
      vectors, z, {0.0, 3.0}, tolerance{.rtol = 1e-5, .atol = std::vector<double>{1e-5, 1e-3, 1e-7, 1e-2, 1e-2, 1e-2}});
  REQUIRE(report);
  CHECK(report.statistics.steps == expected.statistics.steps);
  CHECK((eigen(y.r) - z.r).lpNorm<Eigen::Infinity>() <= 1e-12);
}
TEST_CASE("motions of fields take the steps of Eigen's vectors") {
  const tolerance control{.rtol = 1e-5, .atol = {1e-5, 1e-6}};
  compare_swings(fields::Swings{}, swings, velocity_verlet, fixed(0.01), 1e-12);
  compare_swings(fields::Swings{}, swings, symplectic_euler, fixed(0.01), 1e-12);
  compare_swings(fields::Swings{}, swings, srkn6b, fixed(0.01), 1e-12);
  compare_swings(fields::Swings{}, swings, velocity_verlet, control, 1e-10);
  compare_swings(fields::DampedSwings{}, damped, trapezoidal, fixed(0.01), 1e-12);
  compare_swings(fields::DampedSwings{}, damped, tr_bdf2, control, 1e-7);
  // A field put back has another stamp: the step to the event starts anew there, with a = M⁻¹Ψ, off by Δt³.
  compare_swings(fields::DampedSwings{}, damped, generalized_alpha(0.5), fixed(0.01), 1e-5);
  compare_swings(fields::DampedSwings{}, damped, tsit5, control, 1e-12);
  compare_swings(fields::DampedSwings{}, damped, dop853, control, 1e-12);
}

TEST_CASE("a step of a field makes no vector, and asks all ranks no more than it must") {
  LocalField y = local_field({1, 2, 3});
  const auto count = [&y](auto& stepper, auto&& counts) {
    double t = 0;
    for (int k = 0; k < 3; ++k, t += 0.01) REQUIRE(stepper.step(y, t, 0.01));
    const LocalOps::Counts before = LocalOps::counts();
    for (int k = 0; k < 10; ++k, t += 0.01) REQUIRE(stepper.step(y, t, 0.01));
    CHECK(LocalOps::counts().alive == before.alive);
    counts((LocalOps::counts().combinations - before.combinations) / 10,
           (LocalOps::counts().reductions - before.reductions) / 10);
  };
  PhiStepper euler{y, fields::Decay{}, forward_euler};
  count(euler, [](long combinations, long reductions) {
    CHECK(combinations == 2);  // Ψ out of the force's own vector, and y + Δt Ψ
    CHECK(reductions == 1);    // whether that is finite
  });
  PhiStepper rosenbrock{y, fields::Decay{}, rodas4, newton(Diagonal{})};
  count(rosenbrock, [](long combinations, long reductions) {
    CHECK(combinations == 39);
    CHECK(reductions == 10);  // six solves, the first with W; J, Ψ, y, and whether y is that of the step before
  });
  Run run{rosenbrock, y, {0.0, 100.0}, tolerance{.rtol = 1e-4, .atol = 1e-6}};
  for (int k = 0; k < 4; ++k) REQUIRE(run.advance());
  const auto tries = [&] { return rosenbrock.statistics().steps + rosenbrock.statistics().rejections; };
  const auto before = LocalOps::counts().reductions, tries_before = tries();
  for (int k = 0; k < 8; ++k) REQUIRE(run.advance());
  // J, ∂Ψ/∂t, six solves, y, the error, Ψ at the end, and whether the next step starts there; a second try, whether it starts
  // where the first did.
  CHECK(LocalOps::counts().reductions - before <= 13 * (tries() - tries_before));
}

TEST_CASE("a field's exception passes through, and the state keeps every bit") {
  const std::vector<double> start{1, 2, 3};
  const auto fail = [&start](auto scheme, int at, bool in_solver) {
    LocalField y = local_field(start);
    Diagonal solver;
    solver.throws_at = in_solver ? at : -1;
    PhiStepper stepper{y, fields::Decay{in_solver ? -1 : at}, scheme, newton(solver)};
    bool thrown = false;
    double t = 0;
    std::vector<double> before = start;
    for (int k = 0; k < 4 && !thrown; ++k) {
      try {
        const bool done = static_cast<bool>(stepper.step(y, t, 0.1));
        REQUIRE(done);
        t += 0.1;
        before = numbers(y);
      } catch (const std::runtime_error& error) {
        thrown = std::string(error.what()).find("of this rank") != std::string::npos;
      }
    }
    CHECK(thrown);
    CHECK(numbers(y) == before);
    // The next step is that of a new stepper.
    REQUIRE(stepper.step(y, t, 0.1));
    LocalField z = local_field(before);
    PhiStepper anew{z, fields::Decay{}, scheme, newton(Diagonal{})};
    REQUIRE(anew.step(z, t, 0.1));
    CHECK(numbers(y) == numbers(z));
  };
  for (int at = 0; at < 8; ++at) {
    CAPTURE(at);
    fail(trapezoidal, at, false);
    fail(rodas4, at, false);
    fail(tr_bdf2, at, true);
    fail(rodas4, at, true);
    if (at < 4) fail(forward_euler, at, false);
    fail(tsit5, at, false);
  }
}
TEST_CASE("… out of a run, wherever it began") {
  for (int at = 0; at < 12; ++at) {
    CAPTURE(at);
    LocalField y = local_field({1, 2, 3});
    PhiStepper stepper{y, fields::Decay{at}, rodas4, newton(Diagonal{})};
    CHECK_THROWS_WITH(integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-6, .atol = 1e-6}),
                      "the force of this rank");
  }
}
TEST_CASE("fixed-point iteration of a field: after a checkpoint the bits are those of a new stepper") {
  LocalField y = local_field({1, 0.5, 0.25});
  PhiStepper stepper{y, fields::Decay{}, trapezoidal, fixed_point()};
  double t = 0;
  for (int n = 0; n < 20; ++n, t += 0.1) {
    CAPTURE(n);
    REQUIRE(stepper.step(y, t, 0.1));
    stepper.forget_unsaved();
    // Fewer iterations than the last step's: done at once, they would leave other last bits.
    LocalField here = local_field(numbers(y)), there = local_field(numbers(y));
    PhiStepper anew{there, fields::Decay{}, trapezoidal, fixed_point()};
    REQUIRE(stepper.step(here, t + 0.1, 0.001));
    REQUIRE(anew.step(there, t + 0.1, 0.001));
    CHECK(numbers(here) == numbers(there));
  }
}
