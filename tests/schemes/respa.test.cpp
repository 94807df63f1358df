// Slow terms called once in k inner steps: the formula, order, reversibility, symplecticity, counts by term, histories of
// inner steps, runs. Faults in the middle of a step and restarts: respa.stress.
#include <phistep/force/at.hpp>
#include <phistep/phistep.hpp>
#include <phistep/schemes/kicks.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "contract/states.hpp"
#include "failure/faults.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_FULL
#include "accuracy/observed_order.hpp"
#include "support/shared_force.hpp"
#endif
#if PHISTEP_STRESS
#include "contract/restart.hpp"
#endif

namespace respa_cases {

using namespace phistep;
using Vec = Eigen::VectorXd;

/// Friction by an anchor that follows; tells what was done with it.
struct Slider : ForceTerm {
  static constexpr const char* name = "slider";
  struct Memory {
    Vec anchor;
    int begins = 0, commits = 0;
    double last_dt = 0, last_end = 0;
    void archive(auto& ar) {
      ar("anchor", anchor, "begins", begins, "commits", commits, "last_dt", last_dt, "last_end", last_end);
    }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void begin(double, double dt, const auto& y, Memory& m) {
    if (m.anchor.size() == 0) m.anchor = y.r;
    ++m.begins, m.last_dt = dt;
  }
  static void add(double, const auto& y, const Memory& m, auto& out) {
    out.force += faults::struck<Vec>(faults::Site::force, Vec(-30 * (y.r - m.anchor)));
  }
  static void commit(double t, const auto& y, Memory& m) {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - 0.05, y.r[i] + 0.05);
    ++m.commits, m.last_end = t;
  }
};
/// A slow force that keeps a list, as pairs do: work saved, and no history.
struct Listed : ForceTerm {
  static constexpr const char* name = "listed";
  struct Memory {
    static constexpr bool is_cache = true;
    double since = 0, last_dt = 0;
    int age = 0;
    void archive(auto& ar) { ar("since", since, "last_dt", last_dt, "age", age); }
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  static void begin(double t, double dt, const auto&, Memory& m) { m.since = t, m.last_dt = dt; }
  static void add(double, const auto& y, const Memory&, auto& out) {
    out.force += faults::struck<Vec>(faults::Site::force, Vec(-y.r.array().sin()));
  }
  static void commit(double, const auto&, Memory& m) { ++m.age; }
};
inline const auto six = [] { return states::SecondOrder<Vec>{}.state; };
inline Vec pull(const Vec& r) { return faults::struck<Vec>(faults::Site::force, Vec(-5 * r)); }
inline const auto sliding = [](const auto& y) {
  return PhiStepper{y, Slider{} + term(pull) + seldom(2, Listed{}) + seldom(4, pull), velocity_verlet};
};

}  // namespace respa_cases

#if PHISTEP_FULL

using namespace phistep;
using namespace respa_cases;
using problems::march;
using V2 = Eigen::Vector2d;

namespace {

using Pull = shared_force::OfState<V2>;
const Pull bond = [](const V2& r) -> V2 { return -25 * r - r.squaredNorm() * r; };
const Pull middle = [](const V2& r) -> V2 { return -2 * r.array().sin(); };
const Pull slow = [](const V2& r) -> V2 { return V2{-std::sin(r[0] + r[1]), 0.3 - std::sin(r[0] + r[1])}; };
const Pull whole = [](const V2& r) -> V2 { return bond(r) + middle(r) + slow(r); };
/// Two levels, and three: a type of force each.
auto both(const Pull& fast, int k, const Pull& rare) { return term(fast) + seldom(k, rare); }
auto levels(int k, int all) { return both(bond, k, middle) + seldom(all, slow); }
Motion<V2> start() { return {V2{1, 0.2}, V2{0.3, -0.5}}; }

/// (1) and (2) of kicks.hpp for three levels, level by level and not as one loop.
template <int halves>
void by_hand(Motion<V2>& y, double dt, int k, int all) {
  const auto euler_or_verlet = [&y](double h) {
    if (halves != 2) y.v += (2 - halves) * h / 2 * bond(y.r);
    y.r += h * y.v;
    if (halves != 0) y.v += halves * h / 2 * bond(y.r);
  };
  const auto around = [&y](const auto& force, double h, int n, const auto& step) {
    if (halves != 2) y.v += (2 - halves) * h / 2 * force(y.r);
    for (int i = 0; i < n; ++i) step(h / n);
    if (halves != 0) y.v += halves * h / 2 * force(y.r);
  };
  around(slow, dt, all / k, [&](double h) { around(middle, h, k, euler_or_verlet); });
}
template <int halves>
void check_formula(auto scheme) {
  for (const auto& [k, all] : {std::pair{3, 12}, std::pair{2, 6}, std::pair{1, 5}, std::pair{4, 4}, std::pair{1, 1}}) {
    CAPTURE(k, all);
    Motion<V2> y = start(), by_formula = start();
    PhiStepper stepper{y, levels(k, all), scheme};
    for (int n = 0; n < 20; ++n) {
      problems::step(stepper, y, 0.1 * n, 0.1);
      by_hand<halves>(by_formula, 0.1, k, all);
    }
    CHECK(problems::distance(y, by_formula) < 1e-13);
  }
}

void check_orders(auto scheme, double order, int coarsest, double margin) {
  const Motion<V2> exact = march(PhiStepper{start(), whole, srkn11b}, start(), 0.0, 2.0, 2000);
  convergence::check_order(convergence::errors(coarsest,
                                               [&](int n) {
                                                 PhiStepper stepper{start(), levels(2, 4), scheme};
                                                 return problems::distance(march(stepper, start(), 0.0, 2.0, n), exact);
                                               }),
                           order, margin);
}

}  // namespace

TEST_CASE("a step is the textbook's, three levels deep") {
  check_formula<1>(velocity_verlet);
  check_formula<0>(symplectic_euler);
  check_formula<2>(symplectic_euler_adjoint);
}

TEST_CASE("order 2 around Verlet, 1 around the symplectic Euler schemes") {
  check_orders(velocity_verlet, 2, 40, 0.05);
  check_orders(symplectic_euler, 1, 640, 0.05);
  check_orders(symplectic_euler_adjoint, 1, 640, 0.05);
}

TEST_CASE("k inner steps of a slow force that is 0 are k steps") {
  const Pull nothing = [](const V2& r) -> V2 { return 0 * r; };
  const auto check = [&](auto scheme) {
    const auto split = march(PhiStepper{start(), both(bond, 4, nothing), scheme}, start(), 0.0, 1.0, 16);
    CHECK(problems::distance(split, march(PhiStepper{start(), bond, scheme}, start(), 0.0, 1.0, 64)) < 1e-14);
  };
  check(velocity_verlet), check(symplectic_euler), check(symplectic_euler_adjoint);
}

TEST_CASE("Verlet with slow terms goes back the way it came") {
  Motion<V2> y = start();
  PhiStepper stepper{y, levels(2, 8), velocity_verlet};
  for (int n = 0; n < 300; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  CHECK(problems::distance(y, start()) > 0.1);
  y.v = -y.v;
  for (int n = 0; n < 300; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  y.v = -y.v;
  CHECK(problems::distance(y, start()) < 1e-11);
  Motion<V2> other = start();
  for (int n = 0; n < 50; ++n) problems::step(stepper, other, 0.1 * n, 0.1);
  for (int n = 50; n > 0; --n) problems::step(stepper, other, 0.1 * n, -0.1);
  CHECK(problems::distance(other, start()) < 1e-13);
}

TEST_CASE("the step is symplectic: DᵀJD = J") {
  const auto check = [](auto scheme) {
    Eigen::Matrix4d D, J = Eigen::Matrix4d::Zero();
    J.topRightCorner<2, 2>().setIdentity();
    J.bottomLeftCorner<2, 2>() = -Eigen::Matrix2d::Identity();
    const double h = 1e-5;
    for (int c = 0; c < 4; ++c) {
      Eigen::Vector4d ends[2];
      for (const int side : {0, 1}) {
        Motion<V2> y = start();
        (c < 2 ? y.r : y.v)[c % 2] += side == 0 ? -h : h;
        PhiStepper stepper{y, levels(2, 4), scheme};
        problems::step(stepper, y, 0.0, 0.3);
        ends[side] << y.r, y.v;
      }
      D.col(c) = (ends[1] - ends[0]) / (2 * h);
    }
    CHECK((D.transpose() * J * D - J).norm() < 2e-9);  // h² and ε/h
    CHECK((D - Eigen::Matrix4d::Identity()).norm() > 0.5);
  };
  check(velocity_verlet), check(symplectic_euler), check(symplectic_euler_adjoint);
}

TEST_CASE("no energy drifts away; where an outer step is half a period of the fast motion, a slow force drives it") {
  // r'' = −(ω² + s) r, the s part called once in 8 inner steps
  const auto growth = [](double omega, double dt, int steps) {
    Motion<V2> y{V2{1, 0}, V2{0, 0}};
    const double s = 0.04 * omega * omega;
    PhiStepper stepper{
        y, both([=](const V2& r) -> V2 { return -omega * omega * r; }, 8, [=](const V2& r) -> V2 { return -s * r; }),
        velocity_verlet};
    double most = 0;
    for (int n = 0; n < steps; ++n) {
      problems::step(stepper, y, n * dt, dt);
      most = std::max(most, y.v[0] * y.v[0] / 2 + (omega * omega + s) * y.r[0] * y.r[0] / 2);
    }
    return most / ((omega * omega + s) / 2);
  };
  for (const double dt : {0.5, 1.0, 2.0, 2.7}) CHECK(growth(1, dt, 20000) < 1.5);
  CHECK(growth(1, 3.06, 2000) > 1e10);  // π, less what Verlet is ahead and what the slow force adds
  CHECK(growth(1, 3.3, 20000) < 10);
}

// ---- what is called when ----------------------------------------------------------------------------------------------

namespace {

struct Counted {
  int* calls;
  double k;
  Vec operator()(const Vec& r) const {
    ++*calls;
    return -k * r;
  }
};
struct Calls {
  std::array<int, 3> seen{};
  std::array<std::int64_t, 3> told{};
  Statistics statistics;
};
Calls calls(auto scheme, int steps, const std::vector<int>& edits = {}) {
  Calls all;
  Motion<Vec> y{Vec::Ones(4), Vec::Zero(4)};
  PhiStepper stepper{
      y, term(Counted{&all.seen[0], 20}) + seldom(2, Counted{&all.seen[1], 2}) + seldom(8, Counted{&all.seen[2], 1}),
      scheme};
  for (int n = 0; n < steps; ++n) {
    for (const int edit : edits)
      if (edit == n) y.r[2] += 0.01;
    problems::step(stepper, y, 0.01 * n, 0.01);
  }
  all.told = stepper.calls_by_term();
  all.statistics = stepper.statistics();
  for (std::size_t k = 0; k < 3; ++k) CHECK(all.told[k] == all.seen[k]);
  CHECK(all.statistics.force_calls == all.seen[0]);
  CHECK(all.statistics.kick_calls == all.seen[1] + all.seen[2]);
  CHECK(all.statistics.steps == steps);
  return all;
}

}  // namespace

TEST_CASE("each term is called when it is due, and counted by term") {
  CHECK(calls(velocity_verlet, 10).seen == std::array{81, 41, 11});
  CHECK(calls(symplectic_euler, 10).seen == std::array{80, 40, 10});
  CHECK(calls(symplectic_euler_adjoint, 10).seen == std::array{80, 40, 10});
  // An edit of r between steps: all are asked again. One of v alone: none.
  CHECK(calls(velocity_verlet, 10, {3, 7}).seen == std::array{83, 43, 13});
}

TEST_CASE("an edit of the velocities costs no call; access to the force forgets all") {
  int fast = 0, rare = 0;
  Motion<Vec> y{Vec::Ones(4), Vec::Zero(4)};
  PhiStepper stepper{y, term(Counted{&fast, 20}) + seldom(4, Counted{&rare, 1}), velocity_verlet};
  problems::step(stepper, y, 0.0, 0.1);
  y.v[1] = 3;
  problems::step(stepper, y, 0.1, 0.1);
  CHECK(fast == 9);
  CHECK(rare == 3);
  std::get<1>(stepper.force().terms).force.k = 100;
  problems::step(stepper, y, 0.2, 0.1);
  CHECK(fast == 14);
  CHECK(rare == 5);
  stepper.reset();
  problems::step(stepper, y, 0.3, 0.1);
  CHECK(rare == 7);
}

TEST_CASE("calls by term of a sum without slow terms, and of one with kicks") {
  int a = 0, b = 0;
  Motion<Vec> y{Vec::Ones(4), Vec::Zero(4)};
  PhiStepper plain{y, term(Counted{&a, 20}) + term(Counted{&b, 1}), velocity_verlet};
  for (int n = 0; n < 5; ++n) problems::step(plain, y, 0.1 * n, 0.1);
  CHECK(plain.calls_by_term() == std::array<std::int64_t, 2>{a, b});
  a = b = 0;
  PhiStepper split{y, at(forward_euler, Counted{&a, 1}) + term(Counted{&b, 20}), velocity_verlet};
  for (int n = 0; n < 5; ++n) problems::step(split, y, 0.1 * n, 0.1);
  CHECK(split.calls_by_term() == std::array<std::int64_t, 2>{a, b});
  CHECK(a == 6);
}

TEST_CASE("nested sums are the same levels, to the bit, and the order of terms doesn't matter") {
  const auto run = [](const auto& force) {
    return march(PhiStepper{start(), force, velocity_verlet}, start(), 0.0, 1.0, 10);
  };
  const Motion<V2> flat = run(levels(2, 8));
  const Motion<V2> nested = run(term(bond) + seldom(2, term(middle) + seldom(4, slow)));
  const Motion<V2> turned = run(seldom(8, slow) + term(bond) + seldom(2, middle));
  CHECK(flat.r == nested.r);
  CHECK(flat.v == nested.v);
  CHECK(problems::distance(flat, turned) < 1e-14);
}

TEST_CASE("numbers of inner steps that can't work are refused") {
  CHECK_THROWS_AS(seldom(0, slow), std::invalid_argument);
  CHECK_THROWS_AS(seldom(-3, slow), std::invalid_argument);
  Motion<V2> y = start();
  PhiStepper stepper{y, levels(4, 6), velocity_verlet};
  CHECK_THROWS_WITH(stepper.step(y, 0, 0.1), contains("seldom(4") && contains("seldom(6") && contains("divide"));
  CHECK(problems::distance(y, start()) == 0);
}

TEST_CASE("an inner step that t can't tell from none is refused") {
  Motion<V2> y = start();
  PhiStepper stepper{y, levels(1, 64), velocity_verlet};
  CHECK(stepper.step(y, 1e15, 2.0).outcome() == Outcome::step_too_small);
  CHECK(problems::distance(y, start()) == 0);
}

TEST_CASE("friction among the fast terms: solved for v in inner steps") {
  const auto drag = [](const V2& r, const V2& v) -> V2 { return bond(r) - 0.8 * v; };
  const auto all = [&](const V2& r, const V2& v) -> V2 { return drag(r, v) + slow(r); };
  const Motion<V2> exact = march(PhiStepper{start(), all, tsit5}, start(), 0.0, 2.0, 2000);
  convergence::check_order(
      convergence::errors(40,
                          [&](int n) {
                            PhiStepper stepper{start(), term(drag) + seldom(4, slow), velocity_verlet};
                            return problems::distance(march(stepper, start(), 0.0, 2.0, n), exact);
                          }),
      2, 0.05);
}

namespace {

/// Notes when it is asked.
struct Wind : ForceTerm {
  std::vector<double>* times;
  static constexpr bool uses_velocity = false, uses_time = true;
  explicit Wind(std::vector<double>* all) : times{all} {}
  void add(double t, const auto& /*y*/, auto& /*out*/) const { times->push_back(t); }
};

}  // namespace

TEST_CASE("slow forces of time are asked at their times") {
  std::vector<double> times;
  Motion<V2> y = start();
  PhiStepper stepper{y, term(bond) + seldom(2, Wind{&times}) + seldom(4, slow), velocity_verlet};
  for (int n = 0; n < 2; ++n) problems::step(stepper, y, 1 + 0.5 * n, 0.5);
  CHECK(times == std::vector{1.0, 1.25, 1.5, 1.75, 2.0});
}

TEST_CASE("masses, diagonal and full") {
  const V2 m{2, 0.5};
  const auto check = [&](const auto& spec) {
    Motion<V2> y = start(), hand = start();
    PhiStepper stepper{y, both(bond, 2, slow), velocity_verlet, spec};
    for (int n = 0; n < 20; ++n) {
      problems::step(stepper, y, 0.1 * n, 0.1);
      const auto a = [&](const V2& f) -> V2 { return f.cwiseQuotient(m); };
      hand.v += 0.05 * a(slow(hand.r));
      for (int i = 0; i < 2; ++i) {
        hand.v += 0.025 * a(bond(hand.r));
        hand.r += 0.05 * hand.v;
        hand.v += 0.025 * a(bond(hand.r));
      }
      hand.v += 0.05 * a(slow(hand.r));
    }
    CHECK(problems::distance(y, hand) < 1e-13);
  };
  check(mass(m));
  check(mass(Eigen::Matrix2d(m.asDiagonal())));
}

// ---- histories --------------------------------------------------------------------------------------------------------

TEST_CASE("histories begin and end with the inner steps of their own term") {
  faults::fault = {};
  auto y = six();
  auto stepper = sliding(y);
  for (int n = 0; n < 5; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  const auto& [slider, none, listed, other] = stepper.memory();
  CHECK(slider.begins == 20);
  CHECK(slider.commits == 20);
  CHECK(slider.last_dt == 0.1 / 4);
  CHECK(slider.last_end == Approx(0.5));
  CHECK(listed.age == 10);
  CHECK(listed.last_dt == 0.1 / 2);
  CHECK(listed.since == Approx(0.45));
}

TEST_CASE("the message names the slow term that is not finite, and where in the step") {
  const Pull bad = [](const V2& r) -> V2 { return V2{0, 1 / std::max(r[0] - 0.98, 0.0) * 0.0}; };  // NaN below 0.98
  Motion<V2> y = start();
  PhiStepper stepper{y, both(bond, 4, slow) + seldom(2, bad), velocity_verlet};
  const StepReport report = stepper.step(y, 0, 0.2);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK_THAT(report.message(), contains("term 2") && contains("dt = 0.2"));
  CHECK(problems::distance(y, start()) == 0);
}

// ---- runs -------------------------------------------------------------------------------------------------------------

TEST_CASE("an event cuts the outer step: the state there is that of a step of its length") {
  Motion<V2> y = start(), at_event = start();
  PhiStepper stepper{y, levels(2, 8), velocity_verlet};
  double found = 0;
  auto stop = event([](const auto& state) { return state.r[0] - 0.3; }, {.terminal = true},
                    [&](double t, const auto&) { found = t; });
  const RunReport report = integrate(stepper, y, {0.0, 2.0}, fixed(0.2), stop);
  CHECK(report.outcome == Outcome::stopped_by_event);
  CHECK(std::abs(y.r[0] - 0.3) < 1e-9);
  REQUIRE(found > 0.2);
  PhiStepper direct{at_event, levels(2, 8), velocity_verlet};
  const int before = static_cast<int>(found / 0.2);
  for (int n = 0; n < before; ++n) problems::step(direct, at_event, 0.2 * n, 0.2);
  problems::step(direct, at_event, 0.2 * before, found - 0.2 * before);
  CHECK(problems::distance(at_event, y) < 1e-12);
}

TEST_CASE("a sample inside an outer step is a step of its length, not a parabola over the fast motion") {
  Motion<V2> y = start();
  PhiStepper stepper{y, levels(2, 8), velocity_verlet};
  std::vector<Motion<V2>> seen;
  const std::vector<double> times{0.13, 0.2, 0.33};
  const RunReport report = integrate(stepper, y, {0.0, 0.4}, fixed(0.2),
                                     sampled(times, [&](double, const auto& state) { seen.push_back(state); }));
  REQUIRE(report);
  REQUIRE(seen.size() == 3);
  Motion<V2> z = start();
  PhiStepper direct{z, levels(2, 8), velocity_verlet};
  problems::step(direct, z, 0.0, 0.13);
  CHECK(problems::distance(z, seen[0]) == 0);
  Motion<V2> end = start();
  PhiStepper even{end, levels(2, 8), velocity_verlet};
  for (int n = 0; n < 2; ++n) problems::step(even, end, 0.2 * n, 0.2);
  CHECK(y.r == end.r);
  CHECK(y.v == end.v);

  // A run that has to stop there cuts its outer step in two, as at any dt.
  Motion<V2> cut = start(), direct_cut = start();
  PhiStepper cutter{cut, levels(2, 8), velocity_verlet}, by_hand_cutter{cut, levels(2, 8), velocity_verlet};
  REQUIRE(integrate(cutter, cut, {0.0, 0.2}, fixed(0.2), at_times({0.13}, [](double, const auto&) {})));
  problems::step(by_hand_cutter, direct_cut, 0.0, 0.13);
  problems::step(by_hand_cutter, direct_cut, 0.13, 0.2 - 0.13);
  CHECK(problems::distance(cut, direct_cut) < 1e-15);
  CHECK(cutter.statistics().steps == 2);
}

TEST_CASE("halving does an outer step as two, with the same number of inner steps each") {
  Motion<V2> y = start();
  bool strikes = true;
  const Pull moody = [&](const V2& r) -> V2 { return std::exchange(strikes, false) ? V2{NAN, 0} : slow(r); };
  Halving stepper{PhiStepper{y, both(bond, 4, moody), velocity_verlet}};
  REQUIRE(stepper.step(y, 0, 0.2));
  Motion<V2> z = start();
  const Motion<V2> halves = march(PhiStepper{z, both(bond, 4, slow), velocity_verlet}, z, 0.0, 0.2, 2);
  CHECK(problems::distance(y, halves) == 0);
}

TEST_CASE("the energy ledger's books close, with the energies of slow terms in them") {
  const auto energy_of = [](double k) { return [k](const V2& r) { return k / 2 * r.squaredNorm(); }; };
  const auto force_of = [](double k) { return [k](const V2& r) -> V2 { return -k * r; }; };
  Motion<V2> y = start();
  PhiStepper stepper{y,
                     term(with_energy(force_of(20), energy_of(20))) + seldom(4, with_energy(force_of(1), energy_of(1))),
                     velocity_verlet};
  EnergyLedger ledger{stepper};
  REQUIRE(integrate(stepper, y, {0.0, 20.0}, fixed(0.2), ledger));
  CHECK(ledger.start() == Approx(start().v.squaredNorm() / 2 + 10.5 * start().r.squaredNorm()));
  CHECK(ledger.energy() == Approx(y.v.squaredNorm() / 2 + 10.5 * y.r.squaredNorm()));
  CHECK(std::abs(ledger.closure()) < 1e-12);
  CHECK(std::abs(ledger.scheme()) < 0.05 * ledger.start());
  CHECK(ledger.force_calls() == 0);
  // What drag takes within an outer step its ends don't tell: 40 % of it were booked as the scheme's at ωΔt = 2.
  PhiStepper damped{y, term(with_energy(force_of(20), energy_of(20))) + LinearDrag{0.2} + seldom(4, middle),
                    velocity_verlet};
  CHECK_THROWS_WITH(EnergyLedger{damped}, contains("seldom(k, term)") && contains("with an energy alone"));
}

#elif PHISTEP_STRESS
// Slow terms called once in k inner steps: faults inside a step and restarts; the others: respa.test.

using namespace respa_cases;

TEST_CASE("a fault at any call inside a step: state, histories and their counts are those before it") {
  using namespace faults;
  const Make make = machine(six, sliding, 0.5, fixed(0.1));
  // A new run from a fault on counts its times from there.
  const Tally all = every_call("slow terms", make, Site::force, {Kind::nan, Kind::inf, Kind::exception},
                               {.same_end = 1e-13, .renewed = 1e-12});
  INFO(all.first);
  CHECK(all.clean());
  CHECK(all.failures > 500);
  const auto pulls = [](const auto& y) {
    return PhiStepper{y, term(pull) + seldom(2, pull) + seldom(4, pull), symplectic_euler};
  };
  const Tally sizes = every_call("sizes", machine(six, pulls, 0.3, fixed(0.1)), Site::force,
                                 {Kind::size, Kind::exception}, {.same_end = 1e-13, .renewed = 1e-12});
  INFO(sizes.first);
  CHECK(sizes.clean());
  CHECK(sizes.failures > 40);
  fault = {};
}

TEST_CASE("slow terms restart to the same bits, counts by term included") {
  faults::fault = {};
  const restart::Steps uneven{0.05, false};
  const Statistics s = restart::check(uneven, six, sliding);
  CHECK(s.kick_calls == 60 * 2 + 1 + 60 + 1);
  auto y = six();
  auto stepper = sliding(y);
  for (int n = 0; n < 5; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  const std::string saved = restart::bytes(stepper, y);
  auto z = six();
  auto other = sliding(z);
  std::istringstream in(saved);
  load_checkpoint(in, other, z);
  CHECK(other.calls_by_term() == stepper.calls_by_term());
}

#endif
