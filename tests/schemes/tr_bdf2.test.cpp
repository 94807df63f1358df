// TR-BDF2: one factorization, two solves a step, L-stable, order 2.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "accuracy/observed_order.hpp"
#include "contract/states.hpp"
#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include "support/shared_force.hpp"
#endif

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;
using Vec = Eigen::VectorXd;

namespace tr_bdf2_cases {

/// One step of y' = λy from 1 with Δt = 1: R(z).
inline double amplification(double z) {
  const problems::Dahlquist problem{z};
  problems::Dahlquist::State y{1};
  PhiStepper stepper{y, problem, tr_bdf2};
  problems::step(stepper, y, 0.0, 1.0);
  return y[0];
}
/// (1 + √2 ζ)/(1 − ζ)², ζ = γz/2
template <class Z>
Z formula(Z z) {
  const Z zeta = z * (1 - std::sqrt(0.5));
  return (1.0 + std::sqrt(2.0) * zeta) / ((1.0 - zeta) * (1.0 - zeta));
}

inline constexpr int n = 20;  // steps
struct LinearPull {
  Vec operator()(const Vec& y) const { return -4 * y; }
  Eigen::MatrixXd jacobian(const Vec& y) const { return -4 * Eigen::MatrixXd::Identity(y.size(), y.size()); }
};
struct Remembering : ForceTerm {
  struct Memory {};
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto& y, const Memory&, auto& out) const { out.force -= 4 * y.r; }
  void commit(double, const auto&, Memory&) const {}
};

}  // namespace tr_bdf2_cases

using namespace tr_bdf2_cases;

#if PHISTEP_QUICK

using V2 = Eigen::Vector2d;

TEST_CASE("order 2: first order, motion with damping, both non-autonomous, nonlinear, with a mass") {
  using Flow = problems::ForcedFlow<>;
  check_order(errors(50,
                     [](int steps) {
                       const auto y = Flow::exact(0);
                       PhiStepper stepper{y, Flow{}, tr_bdf2, capacity(Flow::capacity)};
                       return distance(march(stepper, y, 0.0, 2.0, steps), Flow::exact(2));
                     }),
              2);
}

TEST_CASE("R(z) is the formula, vanishes at infinity, and has the error constant -0.0404") {
  // Three roundings of numbers of size 1 in b, each amplified by at most β: 4 u max(1, |R|), and Newton's last digit.
  for (const double z : {-1e-3, -0.1, -1.0, -5.0, -40.0, -1e3, -1e6, 0.5}) {
    CAPTURE(z);
    CHECK(std::abs(amplification(z) - formula(z)) <= 8 * 1.2e-16 * std::max(1.0, std::abs(formula(z))));
  }
  CHECK(std::abs(amplification(-1e10)) < 1e-9);
  CHECK(amplification(-1e10) == Approx(formula(-1e10)).epsilon(1e-12));  // the few digits left are right too
  // e^z − R = c z³ (1 + O(z)): the next term is 0.5 % at this z, rounding 1e-16/8e-9·… below it.
  const double z = -5e-3;
  const double constant = (std::expm1(z) - (amplification(z) - 1)) / (z * z * z);
  CHECK(constant == Approx(-0.0404401).epsilon(0.01));
}

TEST_CASE("an oscillator loses energy by the formula, at fourth order") {
  // |R(iωΔt)|² = (1+2η²)/(1+η²)², η = γωΔt/2; the damping ratio is η⁴/(2ωΔt) to leading order.
  using V = Eigen::Matrix<double, 1, 1>;
  for (const double a : {0.01, 0.3, 1.0, 10.0, 1e4}) {  // a = ωΔt, ω = 2
    Motion<V> y{V(0.3), V(-0.8)};
    PhiStepper stepper{y, [](const V& r) -> V { return -12.0 * r; }, tr_bdf2, mass(3.0)};
    const auto energy = [&y] { return 4 * y.r.squaredNorm() + y.v.squaredNorm(); };
    const double before = energy(), eta = a * (1 - std::sqrt(0.5));
    problems::step(stepper, y, 0.0, a / 2);
    const double expected = (1 + 2 * eta * eta) / std::pow(1 + eta * eta, 2);
    CAPTURE(a);
    CHECK(expected == Approx(std::norm(formula(std::complex<double>(0, a)))).epsilon(1e-12));
    // b = y + β(Y−y) cancels by a factor of a at most, in r and in v.
    CHECK(std::abs(energy() / before - expected) <= 50 * 1.2e-16 * std::max(1.0, a));
  }
}

TEST_CASE("a rate that falls by seven decades: what it has hidden shows in the estimate") {
  // y = cos t for any rate.
  const auto falls = [](const Vec& y, double t) -> Vec {
    const double rate = std::sin(t) > 0 ? 1e6 : 0.1;
    return Vec::Constant(1, -rate * (y[0] - std::cos(t)) - std::sin(t));
  };
  Vec y = Vec::Constant(1, std::cos(0.1));
  PhiStepper stepper{y, falls, tr_bdf2};
  double off = 0;
  REQUIRE(integrate(stepper, y, {0.1, 12}, tolerance{.rtol = 1e-3, .atol = 1e-3},
                    [&off](double t, const Vec& now) { off = std::max(off, std::abs(now[0] - std::cos(t))); }));
  CHECK(off < 0.1);
}

TEST_CASE("exact counts: one Jacobian, one factorization a run; the force at the end serves the next step") {
  const shared_force::OfState<V2> pull = [](const V2& y) -> V2 { return -4 * y; };
  const auto count = [](V2 y, auto force) {
    PhiStepper stepper{y, force, tr_bdf2};
    for (int k = 0; k < n; ++k) problems::step(stepper, y, 0.01 * k, 0.01);
    return stepper.statistics();
  };
  const Statistics s = count(V2(1, 2), pull);
  CHECK(s.steps == n);
  CHECK(s.jacobians == 1);
  CHECK(s.factorizations == 1);
  // Two for the Jacobian, one at the start of the run, else only residuals, of which the first starts from a known Ψ.
  CHECK(s.force_calls == 2 + 1 + s.iterations - n);
  CHECK(s.solves == s.iterations);
  CHECK(s.iterations <= 4 * n + 2);
  // Affine: one solve for each resolve, and a residual to check it after ten of them.
  const Statistics promised = count(V2(1, 2), affine(pull));
  CHECK(promised.solves == 2 * n);
  CHECK(promised.iterations == 0);
  CHECK(promised.force_calls == 2 + 1 + n + 10);
}

TEST_CASE("the force carried over stays good: ten thousand steps, stiff and not, as with a fresh force") {
  const shared_force::OfState<V2> two = [](const V2& y) -> V2 { return {-1e6 * (y[0] - y[1]), -0.1 * y[1]}; };
  Eigen::Vector2d carried{2, 1}, fresh = carried;
  PhiStepper a{carried, two, tr_bdf2}, b{fresh, two, tr_bdf2};
  double worst = 0;
  for (int k = 0; k < 10000; ++k) {
    problems::step(a, carried, 0.0, 0.01);
    b.reset();
    problems::step(b, fresh, 0.0, 0.01);
    worst = std::max(worst, (carried - fresh).cwiseAbs().maxCoeff());
  }
  CHECK(a.statistics().force_calls < b.statistics().force_calls);
  // A random walk of 1e4 roundings of numbers ≤ 1 would end at 1e-14, a drift at 1e-12.
  CHECK(worst <= 1e-13);
}

TEST_CASE("the stage values give the embedded estimate, which is of order 3 per step") {
  // y⁺ − ŷ⁺ = Σ (b_i − b̂_i) Δt k_i with b = (w, w, γ/2), b̂ = ((1−w)/3, (3w+1)/3, γ/6), w = √2/4.
  const double g = 2 - std::sqrt(2.0), w = std::sqrt(2.0) / 4;
  using Flow = problems::ForcedFlow<>;
  const auto both = [&](double h) {
    auto y = Flow::exact(0.3);
    const auto y0 = y;
    PhiStepper stepper{y, Flow{}, tr_bdf2, capacity(Flow::capacity)};
    problems::step(stepper, y, 0.3, h);
    const auto& stage = stepper.working().stage();
    Flow::State slope;
    REQUIRE(stepper.slope(0.3, y0, slope));
    const auto base = (y0 + g / 2 * h * slope).eval();
    const auto b = (y0 + stepper.working().beta * (stage - y0)).eval();
    const auto estimate = (((4 * w - 1) / 3 * (base - y0) - (stage - base) / 3 + g / 3 * (y - b)) / (g / 2)).eval();
    return std::pair{distance(y, Flow::exact(0.3 + h)), distance(estimate, Flow::State::Zero())};
  };
  const auto [error, estimate] = both(0.01);
  const auto [error2, estimate2] = both(0.005);
  CHECK(std::log2(estimate / estimate2) == Approx(3).margin(0.1));
  CHECK(estimate / error == Approx(1).margin(0.1));  // it is the error, up to one more order
  CHECK(std::log2(error / error2) == Approx(3).margin(0.1));
}

#elif PHISTEP_FULL
// TR-BDF2 for motions, states of several blocks and every scalar.

TEST_CASE("order 2: first order, motion with damping, both non-autonomous, nonlinear, with a mass") {
  using Flow = problems::ForcedFlow<>;
  check_order(errors(50,
                     [](int steps) {
                       const auto y = Flow::exact(0);
                       PhiStepper stepper{y, Flow{}, tr_bdf2, capacity(Flow::capacity)};
                       return distance(march(stepper, y, 0.0, 2.0, steps), Flow::exact(2));
                     }),
              2);
  using Moved = problems::ForcedMotion<>;
  check_order(errors(50,
                     [](int steps) {
                       const auto y = Moved::exact(0);
                       PhiStepper stepper{y, Moved{}, tr_bdf2, mass(Moved::mass)};
                       return distance(march(stepper, y, 0.0, 2.0, steps), Moved::exact(2));
                     }),
              2);
}

TEST_CASE("order 2: a motion whose force ignores v, against a run of 40 times the steps") {
  using problems::HardeningSpring;
  const auto run = [](int steps) {
    const auto y = HardeningSpring::start();
    return march(PhiStepper{y, HardeningSpring{}, tr_bdf2}, y, 0.0, 2.0, steps);
  };
  const auto reference = run(40 * 800);  // its own error is 1/1600 of the finest run's
  check_order(errors(100, [&](int steps) { return distance(run(steps), reference); }), 2);
}

TEST_CASE("order 2: a motion with a temperature, all blocks by the same row") {
  const auto run = [](int steps) {
    states::Coupled c;
    return states::numbers(march(PhiStepper{c.state, states::WarmPull{}, tr_bdf2}, c.state, 0.0, 1.0, steps));
  };
  const Vec reference = run(40 * 400);
  check_order(errors(50, [&](int steps) { return (run(steps) - reference).norm(); }), 2);
}

TEST_CASE("exact counts: one Jacobian, one factorization a run; the force at the end serves the next step") {
  const auto count = [](auto y, auto force) {
    PhiStepper stepper{y, force, tr_bdf2};
    for (int k = 0; k < n; ++k) problems::step(stepper, y, 0.01 * k, 0.01);
    const Statistics s = stepper.statistics();
    CHECK(s.steps == n);
    CHECK(s.jacobians == 1);
    CHECK(s.factorizations == 1);
    return s;
  };
  const Motion<Vec> motion{Vec::Ones(3), Vec::Zero(3)};
  const auto check = [](const Statistics& s, int known) {
    CHECK(s.force_calls == 1 + s.iterations - known);  // one at the start of the run, else only residuals
    CHECK(s.solves == s.iterations);
    CHECK(s.iterations <= 4 * n + 2);
  };
  check(count(Vec(Vec::Ones(3)), LinearPull{}), n);  // the first resolve starts from y, where Ψ is known
  check(count(motion, LinearPull{}), 0);             // … for a motion from (r + ½γΔt v, v)
  // A force with memory may have changed by the next step: it is asked again.
  // Affine: one solve for each resolve, and a residual to check it after ten of them.
  const Statistics affine_flow = count(Vec(Vec::Ones(3)), affine(LinearPull{}));
  const Statistics affine_motion = count(motion, affine(LinearPull{}));
  CHECK(affine_flow.solves == 2 * n);
  CHECK(affine_motion.solves == 2 * n);
  CHECK(affine_flow.iterations == 0);
  CHECK(affine_flow.force_calls == 1 + n + 10);
  CHECK(affine_motion.force_calls == 1 + 2 * n + 10);
  const Statistics s = count(motion, Remembering{});
  CHECK(s.force_calls > n + s.iterations);
}

TEST_CASE("the force carried over stays good: ten thousand steps, stiff and not, as with a fresh force") {
  struct Two {
    Eigen::Vector2d operator()(const Eigen::Vector2d& y) const { return {-1e6 * (y[0] - y[1]), -0.1 * y[1]}; }
    Eigen::Matrix2d jacobian(const Eigen::Vector2d&) const { return Eigen::Matrix2d{{-1e6, 1e6}, {0, -0.1}}; }
  };
  Eigen::Vector2d carried{2, 1}, fresh = carried;
  PhiStepper a{carried, Two{}, tr_bdf2}, b{fresh, Two{}, tr_bdf2};
  double worst = 0;
  for (int k = 0; k < 10000; ++k) {
    problems::step(a, carried, 0.0, 0.01);
    b.reset();
    problems::step(b, fresh, 0.0, 0.01);
    worst = std::max(worst, (carried - fresh).cwiseAbs().maxCoeff());
  }
  CHECK(a.statistics().force_calls < b.statistics().force_calls);
  // A random walk of 1e4 roundings of numbers ≤ 1 would end at 1e-14, a drift at 1e-12.
  CHECK(worst <= 1e-13);
}

TEMPLATE_TEST_CASE("every scalar: order 2 above the floor of its rounding", "", float, long double) {
  using T = TestType;
  using Flow = problems::ForcedFlow<T>;
  check_order(errors(8,
                     [](int steps) {
                       const auto y = Flow::exact(0);
                       PhiStepper stepper{y, Flow{}, tr_bdf2, capacity(T(Flow::capacity))};
                       return distance(march(stepper, y, T(0), T(2), steps), Flow::exact(2));
                     }),
              2);
}

#endif
