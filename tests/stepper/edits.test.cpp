// The state belongs to the user, who may edit it between steps: nothing carried over may then be stale.
#include <phistep/phistep.hpp>

#include <cmath>
#include <random>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace {

/// One random edit: nothing, a component, a sign, two particles swapped, a component to 0, or another time.
template <class S>
void edit(S& state, double& t, std::mt19937& random) {
  std::uniform_int_distribution<int> kind(0, 6), which(0, 5);
  const int what = kind(random), k = which(random);
  const auto blocks = Blocks<S>::all(state);
  for_each_block(
      [&](auto, auto& block) {
        if (block.size() != 6) return;
        const int other = (k + 3) % 6;
        if (what == 1) component(block, k) += 1e-9;
        if (what == 2) component(block, k) = -component(block, k);
        if (what == 3) std::swap(component(block, k), component(block, other));
        if (what == 4) component(block, k) = 0;
      },
      blocks);
  if (what == 5) t += 0.37;
  if (what == 6) component(std::get<0>(blocks), k) *= 1.001;  // the positions alone
}

/// A hundred steps with edits between them; before each, a fresh stepper takes the same step.
template <class Case>
void check(auto force, auto scheme, double tolerance, unsigned seed) {
  Case c;
  using S = typename Case::State;
  PhiStepper stepper{c.state, force, scheme};
  std::mt19937 random(seed);
  double t = 0, worst = 0;
  for (int n = 0; n < 100; ++n) {
    edit(c.state, t, random);
    PlainState<S> expected = [&] {
      PlainState<S> copy;
      copy_blocks<S>(copy, c.state);
      return copy;
    }();
    PhiStepper fresh{expected, force, scheme};
    REQUIRE(fresh.step(expected, t, 0.05));
    REQUIRE(stepper.step(c.state, t, 0.05));
    worst = std::max(worst, distance(numbers(c.state), numbers(expected)));
    t += 0.05;
  }
  CHECK(worst <= tolerance);
}

double tolerance_of(const char* scheme) {
  const std::string name = scheme;
  return name.find("euler") != name.npos && name.find("backward") == name.npos
             ? 0
             : 1e-12;  // the explicit ones: to the bit
}

template <class Case>
void check_all(auto force) {
  const auto each = [&](const char* name, auto scheme) {
    CAPTURE(name);
    check<Case>(force, scheme, tolerance_of(name), 17);
  };
  for_each_motion_scheme(each);
}
}  // namespace

// Pull knows no velocity: Verlet carries it from step to step.
TEST_CASE("every scheme, dynamic motion: edited states are stepped as by a fresh stepper") {
  check_all<SecondOrder<Dynamic>>(Pull{});
}
TEST_CASE("every scheme, fixed motion") { check_all<SecondOrder<Fixed>>(Pull{}); }
TEST_CASE("first order") {
  check<FirstOrder<Dynamic>>(DrivenPull{}, forward_euler, 0, 11);
  check<FirstOrder<Dynamic>>(DrivenPull{}, phi(0.7), 1e-12, 12);
}

TEMPLATE_TEST_CASE("schemes that carry the force, other kinds of state", "", SecondOrder<Strided>,
                   SecondOrder<Structs>) {
  check<TestType>(Pull{}, velocity_verlet, 1e-12, 3);
  check<TestType>(Pull{}, phi(0.7), 1e-12, 4);
}
TEST_CASE("Verlet to the bit: fixed, dynamic and mapped") {
  for (const unsigned seed : {1u, 2u, 3u}) {
    check<SecondOrder<Fixed>>(Pull{}, velocity_verlet, 0, seed);
    check<SecondOrder<Dynamic>>(Pull{}, velocity_verlet, 0, seed);
    check<SecondOrder<Mapped>>(Pull{}, velocity_verlet, 0, seed);
  }
}
TEST_CASE("forces of v and t, and a user's own state") {
  check<SecondOrder<Dynamic>>(DampedPull{}, velocity_verlet, 1e-12, 5);
  check<SecondOrder<Fixed>>(DampedPull{}, phi(0.7), 1e-12, 6);
  check<FirstOrder<Fixed>>(DrivenPull{}, phi(0.7), 1e-12, 7);
  check<Coupled>(WarmPull{}, phi(0.7), 1e-12, 8);
  check<Coupled>(WarmPull{}, velocity_verlet, 1e-12, 9);
  check<Coupled>(WarmPull{}, tr_bdf2, 1e-12, 10);
  check<SecondOrder<Fixed>>(DampedPull{}, tr_bdf2, 1e-12, 13);
  check<FirstOrder<Dynamic>>(DrivenPull{}, tr_bdf2, 1e-12, 14);
}

TEST_CASE("an edit of long double's sign or exponent is seen") {
  using Long = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  Motion<Long> y{Long::Constant(3, 1.5L), Long::Zero(3)};
  const auto force = [](const Long& r) -> Long { return -r; };
  PhiStepper stepper{y, force, velocity_verlet};
  REQUIRE(stepper.step(y, 0, 0.1L));
  for (const long double factor : {-1.0L, 2.0L}) {
    y.r *= factor;
    auto z = y;
    PhiStepper fresh{z, force, velocity_verlet};
    REQUIRE(stepper.step(y, 0.1L, 0.1L));
    REQUIRE(fresh.step(z, 0.1L, 0.1L));
    CHECK(y.v == z.v);
  }
}

TEST_CASE("an edit that leaves a contact does not meet the contact's tangent") {
  // Stiff for y > 0, soft for y < 0: what was kept from the stiff side must not pass for convergence.
  const auto check_ratio = [](auto one, double stiff) {
    using T = decltype(one);
    using V = Eigen::Matrix<T, 1, 1>;
    const auto force = [stiff](const V& y) -> V { return y[0] > 0 ? V(-static_cast<T>(stiff) * y) : V(-y); };
    for (const T dt : {T(0.5), T(0.25)}) {  // the factors are kept, or made anew from the kept tangent
      V y(1);
      PhiStepper stepper{y, force, backward_euler};
      REQUIRE(stepper.step(y, 0, T(0.5)));
      y[0] = -1;
      REQUIRE(stepper.step(y, T(0.5), dt));
      CAPTURE(stiff, dt);
      CHECK(static_cast<double>(y[0]) == Approx(-1 / (1 + static_cast<double>(dt))).epsilon(1e-6));
    }
  };
  for (const double stiff : {1e4, 1e8, 1e13, 1e18}) check_ratio(1.0, stiff);
  for (const double stiff : {1e3, 1e6, 1e9}) check_ratio(1.0f, stiff);
}

TEST_CASE("an edit out of the old tangent's range fails no step that a fresh stepper takes") {
  const auto cubic = [](const Dynamic& y) -> Dynamic { return -y.array().cube(); };
  Dynamic y = Dynamic::LinSpaced(4, 0.1, 0.2);
  PhiStepper stepper{y, cubic, backward_euler};
  REQUIRE(stepper.step(y, 0, 0.01));
  y = Dynamic::LinSpaced(4, 3, 40);
  Dynamic z = y;
  PhiStepper fresh{z, cubic, backward_euler};
  REQUIRE(fresh.step(z, 0, 0.5));
  REQUIRE(stepper.step(y, 0, 0.5));
  CHECK(distance(y, z) <= 1e-12);
}
