// The stepper that chooses its scheme: failures, checkpoints, allocations. Motions, masses, nets: automatic_stepper.full.
// integrate without it: automatic.
#define EIGEN_RUNTIME_NO_MALLOC
#include "allocation/step_cases.hpp"
#include "run/choice/automatic_cases.hpp"

#include "phistep/base/archive/archive.hpp"

using namespace automatic_cases;

namespace {

using Dynamic = Eigen::VectorXd;
using Rate = Eigen::Ref<Dynamic>;
/// Any y' = f(t, y) of a size that is not known when it compiles, without an allocation: one type of force.
struct Law : ForceTerm {
  std::function<void(double, const Dynamic&, Rate)> rate;
  explicit Law(std::function<void(double, const Dynamic&, Rate)> f) : rate{std::move(f)} {}
  void add(double t, const auto& state, auto& out) const { rate(t, state.y, out.rate); }
};
/// Robertson's.
void react(double /*t*/, const Dynamic& y, Rate out) {
  const double a = 0.04 * y[0], b = 1e4 * y[1] * y[2], c = 3e7 * y[1] * y[1];
  out[0] += b - a, out[1] += a - b - c, out[2] += c;
}
const TimeSpan<double> span{0.0, 1e6};

struct Program {
  Law law{react};
  Dynamic y{{1.0, 0.0, 0.0}};
  tolerance wanted{.rtol = 1e-6, .atol = 1e-12};
  TimeSpan<double> times = span;
  AutomaticStepper<Dynamic, std::reference_wrapper<const Law>> stepper{y, std::cref(law), wanted.rtol};
  Run<decltype(stepper), Dynamic, tolerance> run{stepper, y, times, wanted};
};

}  // namespace

TEST_CASE("a checkpoint at any step, before and after the change of scheme: resumed to the bit") {
  for (const int at : {3, 20, 33, 45}) {
    Program first;
    for (int k = 0; k < at; ++k) REQUIRE(first.run.advance());
    Writer out;
    out.save(first.run);
    first.run.forget_unsaved();
    Program other;
    Reader in{out.bytes()};
    in.load(other.run);
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
  out.save(first.run);
  for (const std::size_t left : {10u, 200u, 400u, 1000u}) {
    if (left >= out.bytes().size()) continue;
    Reader in{out.bytes().first(out.bytes().size() - left)};
    CHECK_THROWS_AS(in.load(other.run), CheckpointError);
    CHECK(other.stepper.active() == 0);
    CHECK(other.y == Dynamic{{1.0, 0.0, 0.0}});
  }
}

TEST_CASE("a force that throws, or isn't finite, at any call leaves the last good step's state") {
  Program whole;
  REQUIRE(whole.run.finish());
  const std::int64_t calls = whole.stepper.statistics().force_calls;
  for (const bool throws : {true, false})
    for (std::int64_t bad = 0; bad + 1 < calls; bad += 11) {  // the last call tells of roundings alone
      std::int64_t count = 0;
      Program program{.law = Law{[&](double t, const Dynamic& x, Rate out) {
                        if (count++ >= bad) {
                          if (throws) throw std::runtime_error("no");
                          out.setConstant(NAN);
                        }
                        react(t, x, out);
                      }}};
      Dynamic good = program.y;
      const auto go = [&] {
        while (program.run.advance()) good = program.y;
      };
      if (throws) {
        CHECK_THROWS_AS(go(), std::runtime_error);
      } else {
        go();
        CHECK_FALSE(program.run.finish());
      }
      CHECK(program.y == good);
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
}

TEST_CASE("stiff, but no matrix can be had: explicit on, and a resumed run knows why") {
  // 1001 unknowns, neither Jacobian nor pattern.
  const Law relaxing{[](double, const Dynamic& y, Rate out) { out.array() -= 1e6 * (y.array() - 1); }};
  const auto make = [&] {
    return Program{.law = relaxing, .y = Dynamic::Zero(1001), .wanted = {.rtol = 1e-4}, .times = {0.0, 1.0}};
  };
  Program first = make(), other = make();
  for (int k = 0; k < 60; ++k) REQUIRE(first.run.advance());
  REQUIRE(first.stepper.uses().count() == 2);
  CHECK(first.stepper.uses().list()[1].cause == SchemeCause::stays_explicit);
  CHECK(first.stepper.is_stiff());
  Writer out;
  out.save(first.run);
  first.run.forget_unsaved();
  Reader in{out.bytes()};
  in.load(other.run);
  CHECK(other.stepper.is_stiff());
  for (int k = 0; k < 100; ++k) REQUIRE((first.run.advance() && other.run.advance()));
  CHECK(other.y == first.y);
  CHECK(other.stepper.statistics() == first.stepper.statistics());
  CHECK(other.stepper.uses().message() == first.stepper.uses().message());
}

TEST_CASE("many unknowns and no pattern: that a pattern would pay is said, though a dense matrix never would") {
  // A diffusion that a factorized pattern would take a tenth of the time for: some 60 stable steps a relaxation.
  const Law rod{[](double, const Dynamic& u, Rate rate) {
    const Eigen::Index n = u.size();
    for (Eigen::Index i = 0; i < n; ++i)
      rate[i] += 500 * ((i > 0 ? u[i - 1] : 0) - 2 * u[i] + (i + 1 < n ? u[i + 1] : 0)) + 1 - u[i];
  }};
  Program program{.law = rod, .y = Dynamic::Zero(1500), .wanted = {.rtol = 1e-3, .atol = 1e-5}, .times = {0.0, 5.0}};
  const RunReport report = program.run.finish();
  REQUIRE(report);
  const SchemeUses& uses = program.stepper.uses();
  REQUIRE(uses.count() == 2);
  CHECK(uses.list()[1].cause == SchemeCause::stays_explicit);
  CHECK_THAT(uses.message(), contains("sparsity(force, pattern)"));
  CHECK(report.statistics.jacobians == 0);
}

TEST_CASE("backward, a view of the caller's numbers, a second run, no run at all") {
  const Law decay{[](double, const Dynamic& y, Rate rate) { rate += automatic_cases::slow(y); }};
  Dynamic y{{std::exp(-1.0), std::exp(-2.0)}};
  REQUIRE(integrate(y, decay, {1.0, 0.0}, {.rtol = 1e-8}));
  CHECK((y.array() - 1).abs().maxCoeff() < 1e-7);
  y.setOnes();
  AutomaticStepper stepper{y, std::cref(decay), 1e-6};
  CHECK(integrate(stepper, y, {0.0, 1.0}, tolerance{.rtol = 1e-6}));
  CHECK(integrate(stepper, y, {1.0, 2.0}, tolerance{.rtol = 1e-6}));
  CHECK(y[0] == Approx(std::exp(-2.0)).epsilon(1e-5));
  CHECK(integrate(y, decay, {2.0, 2.0}, {.rtol = 1e-6}));
  CHECK(integrate(y, decay, {2.0, 3.0}, {.rtol = 2}).outcome == Outcome::invalid_tolerance);
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
  const Law spring{[](double t, const Dynamic& y, Rate rate) {
    rate[0] += y[1], rate[1] -= 1e10 * (y[0] - std::cos(t)) + std::cos(t);
  }};
  for (const double rtol : {1e-2, 1e-4}) {
    Dynamic y{{1.0, 0.0}};
    const auto report = integrate(y, spring, {0.0, 5.0}, {.rtol = rtol, .atol = rtol, .max_steps = 5000});
    REQUIRE(report);
    CHECK(y[0] == Approx(std::cos(5.0)).margin(10 * rtol));
    REQUIRE(report.schemes.count() == 2);
    CHECK(report.schemes.list()[1].scheme == SuitableScheme::radau_iia);
  }
  StiffnessWatch watch{RivalSteps{3.4, 1.0, 10.0}};
  watch.begin_implicit();
  const RateSeen fast{.rate = 4, .dt = 1, .left = 1e6, .turn = -1}, decaying{.rate = 4, .dt = 1, .left = 1e6};
  for (int k = 0; k < 50; ++k) CHECK_FALSE(watch.judge(fast));
  for (int k = 0; k < 3; ++k) CHECK_FALSE(watch.judge(decaying));
  CHECK(watch.judge(decaying));
}
