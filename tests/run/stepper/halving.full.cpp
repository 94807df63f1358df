// Halving: a step that fails is done as smaller ones, all of it or nothing.
#include <phistep/phistep.hpp>

#include <cmath>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "contract/states.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace halving_cases {

/// Sticks where it has moved to; throws or gives a NaN when told, beyond a time.
struct Sticky : ForceTerm {
  struct Memory {
    Vec anchor;
    int commits = 0;
  };
  const double* nan_after;
  const double* throw_after;
  static constexpr bool uses_velocity = false;
  Sticky(const double* a, const double* b) : nan_after(a), throw_after(b) {}
  void begin(double, double, const auto& y, Memory& m) const {
    if (m.anchor.size() == 0) m.anchor = y.r;
  }
  void add(double t, const auto& y, const Memory& m, auto& out) const {
    if (t > *throw_after) throw std::runtime_error("sticky");
    out.force -= 10 * (y.r - m.anchor);
    if (t > *nan_after) out.force[0] = std::nan("");
  }
  void commit(double, const auto& y, Memory& m) const {
    m.anchor = y.r;
    ++m.commits;
  }
};

template <class V>
void check_final_failure(Motion<V> y) {
  double nan_after = HUGE_VAL, throw_after = HUGE_VAL;
  Halving stepper{PhiStepper{y, Sticky{&nan_after, &throw_after}, trapezoidal}, 3};
  problems::step(stepper, y, 0.0, 0.1);
  const Eigen::VectorXd before = states::numbers(y);
  const auto memory = stepper.stepper().memory();
  const auto unharmed = [&] {
    return states::same_bits(states::numbers(y), before) && stepper.stepper().memory().anchor == memory.anchor &&
           stepper.stepper().memory().commits == memory.commits;
  };

  nan_after = 0.16;  // the first half of 0.1 … 0.2 goes well
  const StepReport report = stepper.step(y, 0.1, 0.1);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK(report.failure().dt == Approx(0.1 / 8));
  CHECK(unharmed());
  const Statistics inner = stepper.stepper().statistics();
  CHECK(inner.steps > 1);  // some parts did succeed, and were taken back
  CHECK(stepper.statistics().steps == 1);
  CHECK(stepper.statistics().halvings == 0);

  nan_after = 0.19, throw_after = 0.17;
  CHECK_THROWS_AS(stepper.step(y, 0.1, 0.1), std::runtime_error);
  CHECK(unharmed());
  nan_after = throw_after = HUGE_VAL;

  // From there it goes on as one that never failed.
  auto z = y;
  PhiStepper fresh{z, Sticky{&nan_after, &throw_after}, trapezoidal};
  fresh.set_memory(memory);
  problems::step(stepper, y, 0.1, 0.1);
  problems::step(fresh, z, 0.1, 0.1);
  CHECK(problems::distance(y, z) <= 1e-15);
}

}  // namespace halving_cases

using namespace halving_cases;

namespace {
/// A stepper that moves the state by dt, and fails where `bad(t, dt)` says so.
struct Picky {
  std::function<bool(double, double)> bad;
  Outcome with = Outcome::newton_diverged;
  std::vector<double> done{};  // t, dt of every step that succeeded
  Statistics counts{};
  Failure last{};
  StepReport step(Vec& y, double t, double dt) {
    if (bad(t, dt)) {
      ++counts.failed_steps;
      last.outcome = with, last.t = t, last.dt = dt;
      return {with, 3, &last};
    }
    ++counts.steps;
    done.insert(done.end(), {t, dt});
    y.array() += dt;
    return {Outcome::success, 2, nullptr};
  }
  [[nodiscard]] const Statistics& statistics() const { return counts; }
  [[nodiscard]] static int order() { return 1; }
  void reset() {}
};
}  // namespace

TEST_CASE("only the part that fails is halved") {
  // Between 0.5 and 0.75 no step may be longer than 1/16, elsewhere none longer than ½.
  const auto bad = [](double t, double dt) { return dt > 0.5 || (dt > 1.0 / 16 && t < 0.75 && t + dt > 0.5); };
  Vec y = Vec::Zero(2);
  Halving stepper{Picky{bad}, 10};
  const StepReport report = stepper.step(y, 0.0, 1.0);
  REQUIRE(report);
  const std::vector<double> expected{
      0, 0.5, 0.5, 1.0 / 16, 0.5 + 1.0 / 16, 1.0 / 16, 0.5 + 2.0 / 16, 1.0 / 16, 0.5 + 3.0 / 16, 1.0 / 16, 0.75, 0.25};
  CHECK(stepper.stepper().done == expected);
  CHECK(y[0] == 1);
  // ½+½; the second ½ = ¼+¼; its first ¼ = ⅛+⅛, each ⅛ = 1/16+1/16.
  CHECK(stepper.statistics() == Statistics{.steps = 1, .halvings = 5});
  CHECK(report.iterations() == 5 * 3 + 6 * 2);
  CHECK(stepper.order() == 1);
}

TEST_CASE("at the smallest step the failure is final: typed, and nothing has moved") {
  for (const int halvings : {0, 1, 4}) {
    Vec y = Vec::Constant(2, 0.1);
    Halving stepper{Picky{[](double t, double dt) { return t + dt > 0.9; }}, halvings};
    const StepReport report = stepper.step(y, 0.0, 1.0);
    CHECK(report.outcome() == Outcome::newton_diverged);
    CHECK(report.failure().dt == std::ldexp(1.0, -halvings));
    CHECK(y == Vec::Constant(2, 0.1));
    CHECK(stepper.statistics() == Statistics{.failed_steps = 1});
  }
  CHECK_THROWS_AS((Halving{Picky{[](double, double) { return false; }}, -1}), std::invalid_argument);
}

TEST_CASE("what a smaller step can't cure is reported at once") {
  const auto tries = [](Outcome outcome) {
    Vec y = Vec::Zero(1);
    Halving stepper{Picky{[](double, double) { return true; }, outcome}, 3};
    CHECK(stepper.step(y, 0.0, 1.0).outcome() == outcome);
    return stepper.stepper().counts.failed_steps;
  };
  for (const Outcome hopeless : {Outcome::invalid_step, Outcome::step_too_small, Outcome::not_symmetric})
    CHECK(tries(hopeless) == 1);
  for (const Outcome curable : {Outcome::newton_diverged, Outcome::newton_stalled, Outcome::singular_matrix,
                                Outcome::not_positive_definite, Outcome::non_finite_force, Outcome::non_finite_jacobian,
                                Outcome::linear_solver_failed, Outcome::non_finite_state})
    CHECK(tries(curable) == 4);
  Vec y = Vec::Constant(1, std::nan(""));  // a bad state is no matter of step size
  Halving stepper{Picky{[](double, double) { return true; }, Outcome::non_finite_state}, 3};
  CHECK_FALSE(stepper.step(y, 0.0, 1.0));
  CHECK(stepper.stepper().counts.failed_steps == 1);
}

TEST_CASE("a singular step matrix is cured by a smaller step") {
  // y' = 2y: backward Euler's 1 − 2Δt vanishes at Δt = ½ and only there.
  using V = Eigen::Matrix<double, 1, 1>;
  V y(1.0), z(1.0);
  const auto grow = [](const V& x) -> V { return 2 * x; };
  Halving stepper{PhiStepper{y, grow, backward_euler}, 2};
  REQUIRE(stepper.step(y, 0.0, 0.5));
  CHECK(y[0] == Approx(4.0).epsilon(1e-14));  // 1/(1 − ½)²
  CHECK(stepper.statistics().halvings == 1);
  PhiStepper bare{z, grow, backward_euler};
  CHECK(bare.step(z, 0.0, 0.5).outcome() == Outcome::singular_matrix);

  std::ostringstream text;
  text << stepper.statistics();
  CHECK_THAT(text.str(), contains("halvings            1"));
}

TEST_CASE("who takes back a step of Halving takes back the force's history") {
  const double never = HUGE_VAL;
  Motion<Eigen::Vector2d> y{Eigen::Vector2d::Ones(), Eigen::Vector2d::Constant(0.3)};
  Halving stepper{PhiStepper{y, Sticky{&never, &never}, trapezoidal}, 3};
  problems::step(stepper, y, 0.0, 0.1);
  const auto kept = stepper.checkpoint();
  const auto before = y;
  problems::step(stepper, y, 0.1, 0.1);
  const auto after = y;
  y = before;
  stepper.restore(kept);
  CHECK(stepper.stepper().memory().commits == 1);
  problems::step(stepper, y, 0.1, 0.1);
  CHECK(states::same_bits(states::numbers(y), states::numbers(after)));
}

TEST_CASE("a failure leaves Rannacher's start where it was") {
  using V = Eigen::Matrix<double, 1, 1>;
  double nan_after = HUGE_VAL;
  V y(1.0);
  const auto decay = [&nan_after](const V& x, double t) -> V { return t > nan_after ? V(std::nan("")) : V(-4 * x); };
  Halving stepper{PhiStepper{y, decay, rannacher}, 2};
  nan_after = 0.07;
  CHECK_FALSE(stepper.step(y, 0.0, 0.1));
  nan_after = HUGE_VAL;
  problems::step(stepper, y, 0.0, 0.1);
  CHECK(y[0] == Approx(1 / (1.2 * 1.2)).epsilon(1e-14));
}

TEST_CASE("under a tolerance halving has the error estimate and the dense output of the stepper inside") {
  const auto f = [](const Eigen::Vector2d& y) -> Eigen::Vector2d {
    return {y[1], 10 * (1 - y[0] * y[0]) * y[1] - y[0]};
  };
  const auto run = [&](auto&& stepper) {
    Eigen::Vector2d y(2, 0);
    std::vector<double> seen;
    const RunReport report =
        integrate(stepper, y, {0, 5}, tolerance{.rtol = 1e-6}, sampled(0.3, [&](double, const Eigen::Vector2d& at) {
                    seen.insert(seen.end(), {at[0], at[1]});
                  }));
    REQUIRE(report);
    seen.insert(seen.end(), {y[0], y[1]});
    return std::pair{report.statistics, seen};
  };
  const auto check = [&](const char* name, auto scheme) {
    Eigen::Vector2d y(2, 0);
    const auto [counts, seen] = run(PhiStepper{y, f, scheme});
    const auto [halving_counts, halving_seen] = run(Halving{PhiStepper{y, f, scheme}});
    CAPTURE(name);
    CHECK(halving_counts == counts);
    CHECK(halving_seen == seen);
  };
  check("rodas4", rodas4);
  check("radau", radau);
  check("trapezoidal", trapezoidal);
}

TEST_CASE("at a fixed step an explicit scheme inside is interpolated as it is alone") {
  const auto calls = [](auto&& stepper, Motion<Eigen::Vector2d> y) {
    int samples = 0;
    const RunReport report =
        integrate(stepper, y, {0, 1}, fixed(0.1), sampled(0.013, [&](double, const auto&) { ++samples; }));
    REQUIRE(report);
    CHECK(samples == 77);
    return report.statistics.force_calls;
  };
  const auto pull = [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -r; };
  const Motion<Eigen::Vector2d> y{{1, 0}, {0, 1}};
  CHECK(calls(Halving{PhiStepper{y, pull, velocity_verlet}}, y) == calls(PhiStepper{y, pull, velocity_verlet}, y));
}

// Halving in dynamic vectors, in runs and in another halving.

TEST_CASE("a final failure after good parts leaves state and history to the bit, as does an exception") {
  check_final_failure(Motion<Vec>{Vec::Ones(2), Vec::Constant(2, 0.3)});
}

TEST_CASE("where nothing fails, halving changes no bit and no count") {
  states::SecondOrder<Vec> a, b;
  Halving halving{PhiStepper{a.state, states::Pull{}, velocity_verlet}};
  PhiStepper bare{b.state, states::Pull{}, velocity_verlet};
  const RunReport one = integrate(halving, a.state, {0, 1}, fixed(0.1)),
                  other = integrate(bare, b.state, {0, 1}, fixed(0.1));
  CHECK(one);
  CHECK(states::same_bits(states::numbers(a.state), states::numbers(b.state)));
  CHECK(one.statistics == other.statistics);
}

TEST_CASE("halving halves another halving, and maps in place") {
  states::FirstOrder<states::Strided> c;
  const auto cubic = [](const Vec& y) -> Vec { return 3 * y; };
  Halving stepper{Halving{PhiStepper{c.state, cubic, backward_euler}, 0}, 1};
  REQUIRE(stepper.step(c.state, 0.0, 1.0 / 3));
  CHECK(c.state[0] == Approx(4 * states::positions[0]).epsilon(1e-14));
  CHECK(stepper.statistics().halvings == 1);
}
