// Strang's half kicks with every scheme, mass and kind of term; the quick half is splitting.test.cpp.
#include <phistep/sparse.hpp>

#include "schemes/splitting_cases.hpp"

using namespace splitting_cases;

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
