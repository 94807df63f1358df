// Terms at φ = 0 in an implicit scene: Strang's half kicks.
#include "schemes/splitting_cases.hpp"
#if PHISTEP_FULL
#include "support/shared_force.hpp"
#endif
#if PHISTEP_STRESS
#include <phistep/sparse.hpp>
#endif

using namespace splitting_cases;

#if PHISTEP_FULL

// Fixed sizes, shared types of force: a stepper of dynamic vectors takes seconds to compile.
namespace {

using OfState = shared_force::OfState<V2>;
using V4 = Eigen::Vector4d;

/// The classical Runge-Kutta method, 2000 steps to t = 2: its error does not count beside order 2.
V4 runge_kutta(const std::function<V4(const V4&, double)>& f, V4 y) {
  constexpr double h = 1e-3;
  for (int k = 0; k < 2000; ++k) {
    const double t = k * h;
    const V4 a = f(y, t), b = f(y + h / 2 * a, t + h / 2), c = f(y + h / 2 * b, t + h / 2), d = f(y + h * c, t + h);
    y += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return y;
}
Motion<V2> exact(const shared_force::OfMotionAndTime<V2>& whole) {
  const auto f = [&](const V4& y, double t) -> V4 {
    const V2 r = y.head<2>(), v = y.tail<2>();
    V4 rate;
    rate << v, whole(r, v, t);
    return rate;
  };
  V4 y;
  y << start().r, start().v;
  y = runge_kutta(f, y);
  return {y.head<2>(), y.tail<2>()};
}

Statistics count_of(auto force, auto scheme) {
  Motion<V2> y{V2::Ones(), V2::Zero()};
  PhiStepper stepper{y, force, scheme};
  for (int k = 0; k < n; ++k) problems::step(stepper, y, 0.01 * k, 0.01);
  return stepper.statistics();
}
const OfState pull = [](const V2& r) -> V2 { return -100 * r; };

}  // namespace

TEST_CASE("one step is the formula: half kick, phi-step of the rest, half kick") {
  const double m = 2, h = 0.3, k = 3, e = 0.7;
  Motion<V2> y{V2(0.7, 0), V2(-0.4, 0)};
  const double half_kick = h / 2 * -e * 0.7 / m, v = -0.4 + half_kick, r = 0.7, w = k / m;
  const double v1 = (v - h * w * (r + h / 4 * v)) / (1 + h * h * w / 4), r1 = r + h / 2 * (v + v1);
  const OfState kick = [e](const V2&x) -> V2 { return -e * x; }, rest = [k](const V2&x) -> V2 { return -k * x; };
  PhiStepper stepper{y, term(rest) + at(forward_euler, kick), trapezoidal, mass(m)};
  problems::step(stepper, y, 0.0, h);
  CHECK(y.r[0] == Approx(r1).epsilon(1e-15));
  CHECK(y.v[0] == Approx(v1 - h / 2 * e * r1 / m).epsilon(1e-15));
}

TEST_CASE("order 2 where the scheme inside is, else 1") {
  const auto split = term(OfState(stiff)) + at(forward_euler, OfState(soft));
  const auto end = exact([](const V2& r, const V2&, double) -> V2 { return stiff(r) + soft(r); });
  const auto error = [&](auto scheme) {
    return [=](int steps) {
      return problems::distance(march(PhiStepper{start(), split, scheme}, start(), 0.0, 2.0, steps), end);
    };
  };
  check_order(errors(80, error(trapezoidal)), 2, 0.05);
  check_order(errors(80, error(velocity_verlet)), 2, 0.05);
}

TEST_CASE("order 2 with kicks that depend on v and t, and in first order") {
  const auto split = term(OfState(stiff)) + at(forward_euler, shared_force::OfMotionAndTime<V2>(damped_soft));
  const auto end = exact([](const V2& r, const V2& v, double t) -> V2 { return stiff(r) + damped_soft(r, v, t); });
  const auto error = [&](int steps) {
    return problems::distance(march(PhiStepper{start(), split, trapezoidal}, start(), 0.0, 2.0, steps), end);
  };
  check_order(errors(80, error), 2, 0.05);
}

TEST_CASE("stable to dt omega_e = 2, however stiff the rest") {
  // One step of length 1 of r'' = −(k_s + ω²) r, the ω² part in kicks; v is scaled by the stiff frequency.
  const auto radius = [](double k_s, double omega) {
    const OfState rest = [k_s](const V2&r) -> V2 { return -k_s * r; },
                  kick = [omega](const V2&r) -> V2 { return -omega * omega * r; };
    const double scale = std::max(1.0, std::sqrt(k_s));
    Motion<V2> y{V2(1, 0), V2(0, scale)};  // both columns of the map at once
    PhiStepper stepper{y, term(rest) + at(forward_euler, kick), trapezoidal, mass(1.0)};
    problems::step(stepper, y, 0.0, 1.0);
    const double a = y.r[0], b = y.r[1], c = y.v[0] / scale, d = y.v[1] / scale;
    const double half_trace = (a + d) / 2, det = a * d - b * c, square = half_trace * half_trace - det;
    return square < 0 ? std::sqrt(det) : std::abs(half_trace) + std::sqrt(square);
  };
  for (const double k_s : {0.0, 1e-3, 1.0, 10.0, 1e3, 1e6}) {
    CAPTURE(k_s);
    CHECK(std::abs(radius(k_s, 1.99) - 1) <= 1e-13 * std::max(1.0, std::sqrt(k_s)));
    const double e = (2.01 * 2.01 / 2 - 2) / (1 + k_s / 4), growth = e + std::sqrt(2 * e + e * e);
    CHECK(radius(k_s, 2.01) - 1 == Approx(growth).epsilon(1e-6));
  }
}

TEST_CASE("exact counts: one call of the kicks a step, none for a constant one") {
  int kicks = 0, rest = 0;
  const OfState of_rest = [&rest](const V2& r) -> V2 { return ++rest, -4 * r; };
  const OfState of_kicks = [&kicks](const V2& r) -> V2 { return ++kicks, -4 * r; };
  const auto force = term(of_rest) + at(forward_euler, of_kicks);
  Statistics s = count_of(force, trapezoidal);
  CHECK(s.kick_calls == kicks);
  CHECK(s.force_calls == rest);
  CHECK(s.steps == n);
  CHECK(s.kick_calls == n + 1);
  CHECK(s.factorizations == 1);
  CHECK(s.solves == s.iterations);
  CHECK(count_of(force, velocity_verlet).force_calls == n + 1);  // the rest is carried over the kicks: r stays
  CHECK(count_of(term(pull) + at(forward_euler, Gravity<V1>{V1(-9.81)}), trapezoidal).kick_calls == 1);
  const shared_force::OfMotionAndTime<V2> drag = [](const V2&, const V2& v, double) -> V2 { return -0.1 * v; };
  CHECK(count_of(term(pull) + at(forward_euler, drag), trapezoidal).kick_calls == 4 * n);
}

TEST_CASE("an edit between steps is seen, by kicks and rest") {
  const auto force = term(OfState(stiff)) + at(forward_euler, OfState(soft));
  auto y = start();
  CHECK(worst_after_edits(y, force, trapezoidal) <= 1e-14);
  CHECK(worst_after_edits(y, force, velocity_verlet) <= 1e-14);
}

TEST_CASE("a new parameter of a constant kick counts from the next step on") {
  const auto force = [](double g) { return term(pull) + at(forward_euler, Gravity<V1>{V1(g)}); };
  check_new_parameter(Motion<V2>{V2::Ones(), V2::Zero()}, force(-9.81), force(0));
}

TEST_CASE("history: one begin and one commit a step for kicks and rest, and a failure leaves it") {
  bool poisoned = false;
  const OfState poison = [&poisoned](const V2& r) -> V2 { return poisoned ? V2(r * std::nan("")) : V2(0 * r); };
  check_history(Motion<V2>{V2::Ones(), V2::Constant(3.0)}, pull, poison, poisoned);
}

TEST_CASE("annotations reach the terms inside at") {
  const auto force = affine(term(springs) + at(forward_euler, springs));
  using Force = std::remove_const_t<decltype(force)>;
  using First = ForceTraits<Unwrapped<Parts<Force>::Rest>, MotionView<Vec, UnitMass>, Motion<Vec>::Rate>;
  using Second = ForceTraits<Unwrapped<Parts<Force>::Kicks>, MotionView<Vec, UnitMass>, Motion<Vec>::Rate>;
  static_assert(First::is_affine && Second::is_affine);
}

TEST_CASE("a split scene is sampled, at a fixed dt and under a tolerance") {
  using Plane = Eigen::Vector2d;
  const auto samples = [](auto control) {
    Motion<Plane> y{{1, 0}, {0, 1}};
    const auto spring = [](const Plane& r) -> Plane { return -4 * r; };
    PhiStepper stepper{y, term(spring) + at(forward_euler, Gravity{Plane(0, -1)}), trapezoidal};
    int seen = 0;
    double worst = 0;
    const RunReport report =
        integrate(stepper, y, {0, 1}, control, sampled(0.07, [&](double t, const Motion<Plane>& x) {
                    ++seen;
                    worst = std::max(worst, std::abs(x.r[0] - std::cos(2 * t)));
                  }));
    CHECK(report);
    CHECK(worst < 1e-3);
    return seen;
  };
  CHECK(samples(fixed(0.02)) == 15);
  CHECK(samples(tolerance{.rtol = 1e-5}) == 15);
}

#elif PHISTEP_STRESS
// Strang's half kicks with every scheme, mass and kind of term.

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

TEST_CASE("forward Euler splits nothing") {
  int calls = 0;
  const auto f = Counted{&calls};
  CHECK(count(at(forward_euler, f) + term(springs), forward_euler) == Statistics{.steps = n, .force_calls = n});
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
  CHECK(worst_after_edits(y, force, trapezoidal) <= 1e-14);
  CHECK(worst_after_edits(y, force, tr_bdf2) <= 1e-14);
  CHECK(worst_after_edits(y, force, velocity_verlet) <= 1e-14);
}

TEST_CASE("a new parameter of a constant kick counts from the next step on") {
  check_new_parameter(Motion<Vec>{Vec::Ones(2), Vec::Zero(2)}, term(springs) + at(forward_euler, weight), springs);
}

TEST_CASE("history: one begin and one commit a step for kicks and rest, and a failure leaves it") {
  bool poisoned = false;
  const auto poison = [&poisoned](const Vec& r) -> Vec { return poisoned ? Vec(r * std::nan("")) : Vec(0 * r); };
  check_history(Motion<Vec>{Vec::Ones(2), Vec::Constant(2, 3.0)}, springs, poison, poisoned);
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
  CHECK(count(affine(term(springs) + at(forward_euler, springs)), trapezoidal).kick_calls == n + 1);
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

#endif
