// Edited states, every scheme and every kind of state; the quick half is edits.test.cpp.
#include "run/stepper/edits_cases.hpp"

using namespace edits_cases;

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
