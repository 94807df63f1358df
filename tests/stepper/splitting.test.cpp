// Terms at φ = 0 in an implicit scene: Strang's half kicks.
#include <phistep/sparse.hpp>

#include <cmath>
#include <stdexcept>

#include "contract/states.hpp"
#include "convergence/observed_order.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::march;
using Vec = Eigen::VectorXd;
using V1 = Eigen::Matrix<double, 1, 1>;
using V2 = Eigen::Vector2d;

namespace {

constexpr int n = 20;  // steps

const auto stiff = [](const V2& r) -> V2 { return -9 * r - r.squaredNorm() * r; };
const auto soft = [](const V2& r) -> V2 { return -r.array().sin(); };
const auto damped_soft = [](const V2& r, const V2& v, double t) -> V2 {
  return -r.array().sin() - 0.4 * v.array() * v.norm() + std::cos(2 * t);
};
Motion<V2> start() { return {V2{1, 0.2}, V2{0.3, -0.5}}; }

/// Observed orders against a run of the sum by Verlet or midpoint, fine enough that its error doesn't count.
template <class State>
void check_split_order(const State& y0, auto split, auto whole, auto scheme, double order, int coarsest,
                       double margin) {
  const State exact = march(PhiStepper{y0, whole, midpoint}, y0, 0.0, 2.0, 20000);
  check_order(errors(coarsest,
                     [&](int steps) {
                       return problems::distance(march(PhiStepper{y0, split, scheme}, y0, 0.0, 2.0, steps), exact);
                     }),
              order, margin);
}

/// The eigenvalues' largest magnitude of one step of length 1 of r'' = −(k_s + ω²) r, the ω² part in kicks.
double spectral_radius(auto scheme, double k_s, double omega) {
  const auto force = term([k_s](const V1& r) -> V1 { return -k_s * r; }) +
                     at(forward_euler, [omega](const V1& r) -> V1 { return -omega * omega * r; });
  Eigen::Matrix2d map;
  // v is scaled by the stiff frequency, so that the matrix is well scaled too.
  const double scale = std::max(1.0, std::sqrt(k_s));
  for (int column = 0; column < 2; ++column) {
    Motion<V1> y{V1(column == 0 ? 1.0 : 0.0), V1(column == 1 ? scale : 0.0)};
    PhiStepper stepper{y, force, scheme};
    problems::step(stepper, y, 0.0, 1.0);
    map.col(column) << y.r[0], y.v[0] / scale;
  }
  const double half_trace = map.trace() / 2, det = map.determinant(), square = half_trace * half_trace - det;
  return square < 0 ? std::sqrt(det) : std::abs(half_trace) + std::sqrt(square);
}

struct Counted {
  int* calls;
  Vec operator()(const Vec& r) const {
    ++*calls;
    return -4 * r;
  }
};

template <class F>
Statistics count(F force, auto scheme, const auto&... more) {
  Motion<Vec> y{Vec::Ones(4), Vec::Zero(4)};
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < n; ++k) problems::step(stepper, y, 0.01 * k, 0.01);
  CHECK(stepper.statistics().steps == n);
  return stepper.statistics();
}

const Gravity<V1> weight{V1(-9.81)};
const auto springs = [](const Vec& r) -> Vec { return -100 * r; };

/// A slider: its anchor follows once the stretch exceeds 0.1.
struct Slider : ForceTerm {
  struct Memory {
    Vec anchor;
    int begins = 0, commits = 0;
  };
  static constexpr bool uses_velocity = false, uses_time = false;
  void begin(double, double, const auto& y, Memory& m) const {
    if (m.anchor.size() == 0) m.anchor = y.r;
    ++m.begins;
  }
  void add(double, const auto& y, const Memory& m, auto& out) const { out.force -= 30 * (y.r - m.anchor); }
  void commit(double, const auto& y, Memory& m) const {
    for (Eigen::Index i = 0; i < y.r.size(); ++i) m.anchor[i] = std::clamp(m.anchor[i], y.r[i] - 0.1, y.r[i] + 0.1);
    ++m.commits;
  }
};

}  // namespace

TEST_CASE("one step is the formula: half kick, phi-step of the rest, half kick") {
  const double m = 2, h = 0.3, k = 3, e = 0.7;
  Motion<V1> y{V1(0.7), V1(-0.4)};
  const double half_kick = h / 2 * -e * 0.7 / m, v = -0.4 + half_kick, r = 0.7, w = k / m;
  const double v1 = (v - h * w * (r + h / 4 * v)) / (1 + h * h * w / 4), r1 = r + h / 2 * (v + v1);
  PhiStepper stepper{
      y, at(forward_euler, [e](const V1& x) -> V1 { return -e * x; }) + term([k](const V1& x) -> V1 { return -k * x; }),
      trapezoidal, mass(m)};
  problems::step(stepper, y, 0.0, h);
  CHECK(y.r[0] == Approx(r1).epsilon(1e-15));
  CHECK(y.v[0] == Approx(v1 - h / 2 * e * r1 / m).epsilon(1e-15));
}

TEST_CASE("order 2 where the scheme inside is, else 1") {
  const auto split = term(stiff) + at(forward_euler, soft);
  const auto whole = term(stiff) + term(soft);
  check_split_order(start(), split, whole, trapezoidal, 2, 80, 0.05);
  check_split_order(start(), split, whole, midpoint, 2, 80, 0.05);
  check_split_order(start(), split, whole, tr_bdf2, 2, 160, 0.05);
  check_split_order(start(), split, whole, velocity_verlet, 2, 80, 0.05);
  check_split_order(start(), split, whole, backward_euler, 1, 800, 0.05);
  check_split_order(start(), split, whole, phi(0.7), 1, 800, 0.05);
}

TEST_CASE("order 2 with kicks that depend on v and t, and in first order") {
  check_split_order(start(), term(stiff) + at(forward_euler, damped_soft), term(stiff) + term(damped_soft), trapezoidal,
                    2, 80, 0.05);
  const auto flow = [](const V2& y, double t) -> V2 { return {-y[0] * y[0] + y[1], std::sin(3 * t) - y[0] * y[1]}; };
  const auto decay = [](const V2& y) -> V2 { return {-8 * y[0] - y[1], -5 * y[1] - y[1] * y[1] * y[1]}; };
  check_split_order(V2{1, 0.5}, term(decay) + at(forward_euler, flow), term(decay) + term(flow), trapezoidal, 2, 80,
                    0.05);
  check_split_order(V2{1, 0.5}, term(decay) + at(forward_euler, flow), term(decay) + term(flow), backward_euler, 1, 800,
                    0.05);
}

TEST_CASE("stable to dt omega_e = 2, however stiff the rest") {
  for (const double k_s : {0.0, 1e-3, 1.0, 10.0, 1e3, 1e6}) {
    CAPTURE(k_s);
    // The step's matrix has determinant 1: stable means both eigenvalues on the unit circle, up to rounding.
    CHECK(std::abs(spectral_radius(trapezoidal, k_s, 1.99) - 1) <= 1e-13 * std::max(1.0, std::sqrt(k_s)));
    CHECK(std::abs(spectral_radius(midpoint, k_s, 1.99) - 1) <= 1e-13 * std::max(1.0, std::sqrt(k_s)));
    // With Δt = 1, c = k_s/4: half the trace is (1 − c − ω²/2)/(1 + c) = −1 − ε, and ρ = 1 + ε + √(2ε + ε²).
    const double e = (2.01 * 2.01 / 2 - 2) / (1 + k_s / 4), growth = e + std::sqrt(2 * e + e * e);
    CHECK(spectral_radius(trapezoidal, k_s, 2.01) - 1 == Approx(growth).epsilon(1e-6));
  }
}

TEST_CASE("exact counts: one call of the kicks a step, none for a constant one") {
  int kicks = 0, rest = 0;
  const auto count_split = [&](auto scheme) {
    kicks = rest = 0;
    const Statistics s = count(term(Counted{&rest}) + at(forward_euler, Counted{&kicks}), scheme);
    CHECK(s.kick_calls == kicks);
    CHECK(s.force_calls == rest);
    return s;
  };
  Statistics s = count_split(trapezoidal);
  CHECK(s.kick_calls == n + 1);
  CHECK(s.factorizations == 1);
  CHECK(s.solves == s.iterations);
  CHECK(count_split(velocity_verlet).force_calls == n + 1);  // the rest is carried over the kicks: r stays
  s = count_split(phi(0.7));
  CHECK(s.kick_calls == n + 1);

  CHECK(count(term(springs) + at(forward_euler, weight), trapezoidal).kick_calls == 1);
  CHECK(count(term(springs) + at(forward_euler, weight + UniformForce{V1(2.0)}), trapezoidal).kick_calls == 1);

  const auto drag = [](const Vec&, const Vec& v) -> Vec { return -0.1 * v; };
  CHECK(count(term(springs) + at(forward_euler, drag), trapezoidal).kick_calls == 4 * n);
  CHECK(count(term(springs) + at(forward_euler, Slider{}), trapezoidal).kick_calls == 2 * n);
}

TEST_CASE("a term marked with the scene's own scheme is part of the rest; forward Euler splits nothing") {
  int calls = 0;
  const auto f = Counted{&calls};
  CHECK(count(at(trapezoidal, f) + at(forward_euler, weight), trapezoidal).kick_calls == 1);
  CHECK(count(at(forward_euler, f) + term(springs), forward_euler) == Statistics{.steps = n, .force_calls = n});
  calls = 0;
  CHECK(count(at(trapezoidal, f) + term(springs), trapezoidal).kick_calls == 0);
  CHECK(calls > 0);
}

TEST_CASE("the rest alone decides the solver: kicks do not fill the matrix") {
  constexpr int size = 3000;  // a dense difference Jacobian of that size is refused
  std::vector<Spring> list;
  for (int i = 0; i + 1 < size / 2; ++i) list.push_back({i, i + 1, 100.0, 1.0});
  Motion<Vec> y{Vec::Zero(size), Vec::Zero(size)};
  for (int i = 0; i < size / 2; ++i) y.r[2 * i] = i;
  const auto wind = [](const Vec& r) -> Vec { return 0.01 * r.array().cos(); };
  PhiStepper split{y, spring_network<2>(list) + at(forward_euler, wind), trapezoidal};
  problems::step(split, y, 0.0, 0.1);
  CHECK(split.statistics().factorizations >= 1);
  CHECK_THROWS_AS((PhiStepper{y, spring_network<2>(list) + term(wind), trapezoidal}), std::invalid_argument);
}

TEST_CASE("masses of every kind, and several kicks") {
  const V2 m(1, 2);
  const Eigen::Matrix2d M{{1, 0.2}, {0.2, 2}};
  const auto check = [&](const auto& masses, const Eigen::Matrix2d& matrix) {
    auto y = start(), z = start();
    PhiStepper stepper{y, at(forward_euler, soft) + term(stiff) + at(forward_euler, LinearDrag{0.0}), trapezoidal,
                       masses};
    PhiStepper inner{z, stiff, trapezoidal, masses};
    for (int k = 0; k < 5; ++k) {
      problems::step(stepper, y, 0.1 * k, 0.1);
      z.v += 0.05 * matrix.inverse() * soft(z.r);
      problems::step(inner, z, 0.1 * k, 0.1);
      z.v += 0.05 * matrix.inverse() * soft(z.r);
    }
    CHECK(problems::distance(y, z) <= 1e-14);
  };
  check(mass(2.0), 2 * Eigen::Matrix2d::Identity());
  check(mass(m), m.asDiagonal());
  check(mass(M), M);
}

TEST_CASE("an edit between steps is seen, by kicks and rest") {
  const auto force = term(stiff) + at(forward_euler, soft);
  auto y = start();
  const auto check = [&](auto scheme) {
    PhiStepper stepper{y, force, scheme};
    for (int k = 0; k < 20; ++k) {
      if (k % 3 == 1) y.r[k % 2] += 0.01;
      if (k % 4 == 2) y.v = -y.v;
      auto z = y;
      PhiStepper fresh{z, force, scheme};
      problems::step(stepper, y, 0.1 * k, 0.1);
      problems::step(fresh, z, 0.1 * k, 0.1);
      CHECK(problems::distance(y, z) <= 1e-14);
    }
  };
  check(trapezoidal);
  check(tr_bdf2);
  check(velocity_verlet);
}

TEST_CASE("a new parameter of a constant kick counts from the next step on") {
  Motion<Vec> y{Vec::Ones(2), Vec::Zero(2)};
  PhiStepper stepper{y, term(springs) + at(forward_euler, weight), trapezoidal};
  problems::step(stepper, y, 0.0, 0.01);
  std::get<1>(stepper.force().terms).force.g = V1(0.0);
  auto z = y;
  PhiStepper bare{z, springs, trapezoidal};
  problems::step(stepper, y, 0.01, 0.01);
  problems::step(bare, z, 0.01, 0.01);
  CHECK(problems::distance(y, z) <= 1e-15);
}

TEST_CASE("history: one begin and one commit a step for kicks and rest, and a failure leaves it") {
  Motion<Vec> y{Vec::Ones(2), Vec::Constant(2, 3.0)};
  bool poisoned = false;
  const auto poison = [&poisoned](const Vec& r) -> Vec { return poisoned ? Vec(r * std::nan("")) : Vec(0 * r); };
  PhiStepper stepper{y, Slider{} + at(forward_euler, Slider{}) + at(forward_euler, poison) + term(springs),
                     trapezoidal};
  for (int k = 0; k < 5; ++k) problems::step(stepper, y, 0.1 * k, 0.1);
  const auto check = [&] {
    CHECK(std::get<0>(stepper.memory()).commits == 5);
    CHECK(std::get<1>(stepper.memory()).commits == 5);
    CHECK(std::get<1>(stepper.memory()).begins == 5);
    CHECK(std::get<0>(stepper.memory()).anchor == std::get<1>(stepper.memory()).anchor);
  };
  check();
  poisoned = true;
  const auto before = y;
  const StepReport report = stepper.step(y, 0.5, 0.1);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK(report.failure().term == 2);  // in the user's own order
  CHECK((y.r == before.r && y.v == before.v));
  check();
}

TEST_CASE("a kick that fails at the end of the step names its term") {
  Motion<Vec> y{Vec::Ones(2), Vec::Constant(2, -1.0)};
  const auto root = [](const Vec& r) -> Vec { return (r.array() - 0.95).sqrt(); };
  PhiStepper stepper{y, term(springs) + at(forward_euler, weight) + at(forward_euler, root), trapezoidal};
  const StepReport report = stepper.step(y, 0.0, 0.1);
  CHECK(report.outcome() == Outcome::non_finite_force);
  CHECK(report.failure().term == 2);
  CHECK(y.r == Vec::Ones(2));
}

TEST_CASE("annotations reach the terms inside at") {
  const auto force = affine(term(springs) + at(forward_euler, springs));
  using Force = std::remove_const_t<decltype(force)>;
  using First = ForceTraits<Unwrapped<Parts<Force>::Rest>, MotionView<Vec, UnitMass>, Motion<Vec>::Rate>;
  using Second = ForceTraits<Unwrapped<Parts<Force>::Kicks>, MotionView<Vec, UnitMass>, Motion<Vec>::Rate>;
  static_assert(First::is_affine && Second::is_affine);
  CHECK(count(force, trapezoidal).kick_calls == n + 1);
}

TEST_CASE("a copied or resized stepper is whole") {
  Motion<Vec> y{Vec::Ones(2), Vec::Zero(2)};
  PhiStepper stepper{y, term(springs) + at(forward_euler, springs) + term(springs), tr_bdf2};
  problems::step(stepper, y, 0.0, 0.01);
  auto copy = stepper;
  auto z = y;
  problems::step(stepper, y, 0.01, 0.01);
  problems::step(copy, z, 0.01, 0.01);
  CHECK(problems::distance(y, z) == 0);
  Motion<Vec> larger{Vec::Ones(3), Vec::Zero(3)}, same = larger;
  problems::step(stepper, larger, 0.0, 0.01);
  PhiStepper fresh{same, term(springs) + at(forward_euler, springs) + term(springs), tr_bdf2};
  problems::step(fresh, same, 0.0, 0.01);
  CHECK(problems::distance(larger, same) <= 1e-15);
}
