// The stepper that chooses its scheme: failures, checkpoints, allocations, masses, motions. integrate without it: automatic.
#define EIGEN_RUNTIME_NO_MALLOC
#include "allocation/step_cases.hpp"
#include "choice/automatic_cases.hpp"
#include "problems/drum.hpp"

#include "phistep/archive/archive.hpp"

using namespace automatic_cases;

namespace {

using Dynamic = Eigen::VectorXd;
/// Robertson's, of a size that is not known when it compiles, without an allocation.
struct Reaction : ForceTerm {
  static constexpr bool uses_time = false;
  static void rate(const Dynamic& y, auto& out) {
    const double a = 0.04 * y[0], b = 1e4 * y[1] * y[2], c = 3e7 * y[1] * y[1];
    out[0] += b - a, out[1] += a - b - c, out[2] += c;
  }
  void add(auto /*t*/, const auto& state, auto& out) const { rate(state.y, out.rate); }
};
/// y' = −10⁶ (y − 1)
struct Relaxing : ForceTerm {
  static constexpr bool uses_time = false;
  void add(auto /*t*/, const auto& state, auto& out) const { out.rate.array() -= 1e6 * (state.y.array() - 1); }
};
const TimeSpan<double> span{0.0, 1e6};

struct Program {
  Dynamic y{{1.0, 0.0, 0.0}};
  AutomaticStepper<Dynamic, Reaction> stepper{y, Reaction{}, 1e-6};
  Run<decltype(stepper), Dynamic, tolerance> run{stepper, y, span, tolerance{.rtol = 1e-6, .atol = 1e-12}};
};

}  // namespace

TEST_CASE("a checkpoint at any step, before and after the change of scheme: resumed to the bit") {
  for (const int at : {3, 20, 33, 45}) {
    Program first;
    for (int k = 0; k < at; ++k) REQUIRE(first.run.advance());
    Writer out;
    first.run.save(out);
    first.run.forget_unsaved();
    Program other;
    Reader in{out.bytes()};
    other.run.load(in, [] {});
    CHECK(other.y == first.y);
    CHECK(other.stepper.active() == first.stepper.active());
    const RunReport one = first.run.finish(), two = other.run.finish();
    REQUIRE(one);
    CHECK(other.y == first.y);
    CHECK(one.statistics == two.statistics);
    CHECK(other.stepper.uses().message() == first.stepper.uses().message());
    CHECK(first.stepper.uses().count() == 2);
  }
}

TEST_CASE("a checkpoint cut short is refused, and changes nothing") {
  Program first, other;
  for (int k = 0; k < 40; ++k) REQUIRE(first.run.advance());
  Writer out;
  first.run.save(out);
  for (const std::size_t left : {10u, 200u, 400u, 1000u}) {
    if (left >= out.bytes().size()) continue;
    Reader in{out.bytes().first(out.bytes().size() - left)};
    CHECK_THROWS_AS(other.run.load(in, [] {}), CheckpointError);
    CHECK(other.stepper.active() == 1);
    CHECK(other.y == Dynamic{{1.0, 0.0, 0.0}});
  }
}

TEST_CASE("a force that throws, or isn't finite, at any call leaves the last good step's state") {
  Program whole;
  REQUIRE(whole.run.finish());
  const std::int64_t calls = whole.stepper.statistics().force_calls;
  for (const bool throws : {true, false})
    for (std::int64_t bad = 0; bad < calls; bad += 11) {
      std::int64_t count = 0;
      const auto force = [&](const Dynamic& x) -> Dynamic {
        if (count++ >= bad) {
          if (throws) throw std::runtime_error("no");
          return Dynamic::Constant(3, NAN);
        }
        Dynamic out = Dynamic::Zero(3);
        Reaction::rate(x, out);
        return out;
      };
      Dynamic y{{1.0, 0.0, 0.0}}, good = y;
      const auto keep = [&](double, const Dynamic& now) { good = now; };
      const tolerance wanted{.rtol = 1e-6, .atol = 1e-12};
      if (throws) {
        CHECK_THROWS_AS(static_cast<void>(integrate(y, force, span, wanted, keep)), std::runtime_error);
      } else {
        CHECK_FALSE(integrate(y, force, span, wanted, keep));
      }
      CHECK(y == good);
    }
}

TEST_CASE("no allocation in a step, but in the first of a scheme, and once where it first looks at the rate") {
  Program all;
  REQUIRE(all.run.advance());
  std::int64_t used = all.stepper.uses().count(), quiet = 0, changed = 0, looks = 0;
  for (bool goes_on = true; goes_on;) {
    heap::count = 0, heap::counting = true;
    goes_on = all.run.advance();
    heap::counting = false;
    if (std::exchange(used, all.stepper.uses().count()) != used) {
      ++changed;
    } else if (heap::count != 0) {
      ++looks;
      CHECK(heap::count == 1);
    } else {
      ++quiet;
    }
  }
  CHECK(changed == 1);
  CHECK(looks == 1);
  CHECK(quiet > 50);
}

TEST_CASE("motion: the pair that ignores v, to the bit; stiff bonds: an implicit scheme") {
  const auto pull = [](const Vec& r) -> Vec { return -r / std::pow(r.norm(), 3); };
  Motion y{Vec{1, 0}, Vec{0, 1}}, same = y;
  const tolerance wanted{.rtol = 1e-6};
  const auto report = integrate(y, pull, {0.0, 20.0}, wanted);
  REQUIRE(report);
  REQUIRE(by_hand(same, pull, rkn86, {0.0, 20.0}, wanted));
  CHECK((y.r == same.r && y.v == same.v));
  CHECK(report.statistics.jacobians == 0);

  const auto damped = [](const Vec& r, const Vec& v) -> Vec { return Vec{-1e6 * r[0] - 1e5 * v[0], -r[1]}; };
  Motion z{Vec{1, 1}, Vec{0, 0}};
  const auto other = integrate(z, damped, {0.0, 5.0}, wanted);
  REQUIRE(other);
  CHECK(other.schemes.count() == 2);
  CHECK(z.r[1] == Approx(std::cos(5.0)).epsilon(1e-5));
}

TEST_CASE("a net of stiff springs and dashpots: TR-BDF2 on conjugate gradients, to the tolerance") {
  using problems::Drum;
  Drum::State y = Drum::start();
  const auto report = integrate(y, Drum::force(), mass(Drum::masses()), {0.0, Drum::end}, {.rtol = 1e-4, .atol = 1e-4});
  REQUIRE(report);
  REQUIRE(report.schemes.count() == 2);
  CHECK(report.schemes.list()[1].scheme == SuitableScheme::tr_bdf_2);
  CHECK(report.schemes.list()[1].rate > 4e4);  // 1.6e5, seen from below
  CHECK(report.statistics.linear_iterations > 100);
  CHECK(report.statistics.steps < 1000);  // explicit ones: 40,000
  const Dynamic exact = Drum::exact();
  const auto samples = Drum::samples();
  const Eigen::Index n = y.r.size();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double is = samples[k] < n ? y.r[samples[k]] : y.v[samples[k] - n];
    CHECK(std::abs(is - exact[static_cast<Eigen::Index>(k)]) < 1e-2);
  }
}

TEST_CASE("stiff, but no matrix can be had: explicit on, and a resumed run knows why") {
  // 1001 unknowns, neither Jacobian nor pattern.
  struct Kept {
    Dynamic y = Dynamic::Zero(1001);
    AutomaticStepper<Dynamic, Relaxing> stepper{y, Relaxing{}, 1e-4};
    Run<decltype(stepper), Dynamic, tolerance> run{stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-4}};
  };
  Kept first, other;
  for (int k = 0; k < 60; ++k) REQUIRE(first.run.advance());
  REQUIRE(first.stepper.uses().count() == 2);
  CHECK(first.stepper.uses().list()[1].cause == SchemeCause::stays_explicit);
  CHECK(first.stepper.is_stiff());
  Writer out;
  first.run.save(out);
  first.run.forget_unsaved();
  Reader in{out.bytes()};
  other.run.load(in, [] {});
  CHECK(other.stepper.is_stiff());
  for (int k = 0; k < 100; ++k) REQUIRE((first.run.advance() && other.run.advance()));
  CHECK(other.y == first.y);
  CHECK(other.stepper.statistics() == first.stepper.statistics());
  CHECK(other.stepper.uses().message() == first.stepper.uses().message());
}

TEST_CASE("many unknowns and no pattern: that a pattern would pay is said, though a dense matrix never would") {
  // A diffusion that a factorized pattern would take a tenth of the time for: some 60 stable steps a relaxation.
  const auto rod = [](const Eigen::VectorXd& u) -> Eigen::VectorXd {
    const Eigen::Index n = u.size();
    Eigen::VectorXd rate(n);
    for (Eigen::Index i = 0; i < n; ++i)
      rate[i] = 500 * ((i > 0 ? u[i - 1] : 0) - 2 * u[i] + (i + 1 < n ? u[i + 1] : 0)) + 1 - u[i];
    return rate;
  };
  Eigen::VectorXd y = Eigen::VectorXd::Zero(1500);
  const AutomaticReport report = integrate(y, rod, {0.0, 5.0}, {.rtol = 1e-3, .atol = 1e-5});
  REQUIRE(report);
  REQUIRE(report.schemes.count() == 2);
  CHECK(report.schemes.list()[1].cause == SchemeCause::stays_explicit);
  CHECK_THAT(report.schemes.message(), contains("sparsity(force, pattern)"));
  CHECK(report.statistics.jacobians == 0);
}

TEST_CASE("a singular M: implicit from the start, and for good") {
  Eigen::Vector3d y = Robertson::start(), exact = Robertson::exact();
  const auto algebraic = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    const Eigen::Vector3d rate = Robertson{}(x);
    return {rate[0], rate[1], x.sum() - 1};
  };
  const auto report =
      integrate(y, algebraic, capacity(Eigen::Vector3d(1, 1, 0)), {0.0, 40.0}, tolerance{.rtol = 1e-6, .atol = 1e-12});
  REQUIRE(report);
  CHECK((y - exact).cwiseQuotient(exact).cwiseAbs().maxCoeff() < 1e-5);
  REQUIRE(report.schemes.count() == 1);
  CHECK(report.schemes.list()[0].cause == SchemeCause::algebraic);
}

TEST_CASE("backward, a view of the caller's numbers, a second run, no run at all") {
  double numbers[2] = {std::exp(-1.0), std::exp(-2.0)};
  Eigen::Map<Vec> view(numbers);
  REQUIRE(integrate(view, slow, {1.0, 0.0}, {.rtol = 1e-8}));
  CHECK(numbers[0] == Approx(1).epsilon(1e-7));
  CHECK(numbers[1] == Approx(1).epsilon(1e-7));
  Vec y{1, 1};
  AutomaticStepper stepper{y, slow, 1e-6};
  CHECK(integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-6}));
  CHECK(integrate(stepper, y, {1.0, 2.0}, tolerance{.rtol = 1e-6}));
  CHECK(y[0] == Approx(std::exp(-2.0)).epsilon(1e-5));
  CHECK(integrate(y, slow, {2.0, 2.0}, {.rtol = 1e-6}));
  CHECK(integrate(y, slow, {2.0, 3.0}, {.rtol = 2}).outcome == Outcome::invalid_tolerance);
}

TEST_CASE("when to look, and what is made of it: the rules of the watch") {
  StiffnessWatch watch{RivalSteps{3.0, 1.0, 10.0}};
  CHECK_FALSE(watch.is_implicit());
  for (double dt = 1; dt < 100; dt *= 2) {
    watch.accepted(dt);
    CHECK_FALSE(watch.is_due());  // growing: no limit in sight
  }
  for (int k = 0; k < 5; ++k) {
    CHECK_FALSE(watch.is_due());
    watch.accepted(64);
  }
  CHECK(watch.is_due());
  // At the bound, but the rest of the run is not worth a change.
  CHECK_FALSE(watch.judge({.rate = 3, .dt = 1, .left = 50, .change = 0.1}));
  // At the bound, smooth: two looks. Not near it: none.
  CHECK_FALSE(watch.judge({.rate = 0.3, .dt = 1, .left = 1e6, .change = 0.1}));
  // At the bound, smooth, but an implicit step that does nine explicit ones' work costs ten: never.
  for (int k = 0; k < 9; ++k)
    CHECK_FALSE(watch.judge({.rate = 3, .dt = 1, .left = 1e6, .change = 0.1, .smooth_step = 9}));
  CHECK_FALSE(watch.judge({.rate = 3, .dt = 1, .left = 1e6, .change = 0.1}));
  CHECK(watch.judge({.rate = 3, .dt = 1, .left = 1e6, .change = 0.1}));
  CHECK(watch.pays({.rate = 3, .dt = 1, .left = 1e6, .smooth_step = 11}));
  watch.change();
  CHECK(watch.is_implicit());
  // An implicit step does 30 explicit ones' work: it stays. Three of them: back, after four looks, twice as many as the explicit
  // spell before was short.
  CHECK_FALSE(watch.judge({.rate = 63, .dt = 1, .left = 1e6}));
  // Five of them, which cost half of it: not enough to pay for the change.
  for (int k = 0; k < 20; ++k) CHECK_FALSE(watch.judge({.rate = 11, .dt = 1, .left = 1e6}));
  for (int k = 0; k < 7; ++k) CHECK_FALSE(watch.judge({.rate = 6.3, .dt = 1, .left = 1e6}));
  CHECK(watch.judge({.rate = 6.3, .dt = 1, .left = 1e6}));
}

TEST_CASE("a fast oscillation at rest: tsit5 magnifies it from |z| = 0.5 on, so that it is stiff, and stays so") {
  // r'' = −ω² (r − cos t) as a first-order state, along r = cos t: explicit steps would be 5e5.
  const auto spring = [](const Vec& y, double t) -> Vec { return {y[1], -1e10 * (y[0] - std::cos(t)) - std::cos(t)}; };
  for (const double rtol : {1e-2, 1e-4}) {
    Vec y{1, 0};
    const auto report = integrate(y, spring, {0.0, 5.0}, {.rtol = rtol, .atol = rtol, .max_steps = 5000});
    REQUIRE(report);
    CHECK(y[0] == Approx(std::cos(5.0)).margin(10 * rtol));
    REQUIRE(report.schemes.count() == 2);
    CHECK(report.schemes.list()[1].scheme == SuitableScheme::radau_iia);
  }
  StiffnessWatch watch{RivalSteps{3.4, 1.0, 10.0, 0.9}};
  watch.begin_implicit();
  const RateSeen fast{.rate = 2, .dt = 1, .left = 1e6, .turn = -1}, decaying{.rate = 2, .dt = 1, .left = 1e6};
  for (int k = 0; k < 50; ++k) CHECK_FALSE(watch.judge(fast));
  for (int k = 0; k < 3; ++k) CHECK_FALSE(watch.judge(decaying));
  CHECK(watch.judge(decaying));
}
