// The contract of a state: the same numbers give the same steps in every shape, and views are stepped in place. All
// shapes: the full tier, state_implicit.full.cpp.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "contract/state_cases.hpp"
#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

#if PHISTEP_QUICK

TEMPLATE_TEST_CASE("every shape of a first-order state gives the same trajectory", "", RowMajor, Strided, Reference) {
  check_first_order<TestType>(forward_euler, 0);
}
TEMPLATE_TEST_CASE("every shape of a motion gives the same trajectory", "", Fixed, Columns, Mapped) {
  check_motion<TestType>(Pull{}, velocity_verlet, 0);
}
TEST_CASE("implicit schemes too") {
  // Fixed sizes alone: a dense solve of dynamic size would double what this file takes to compile.
  check_same(run<FirstOrder<FixedColumns>>(DrivenPull{}, phi(0.7)), run<FirstOrder<Fixed>>(DrivenPull{}, phi(0.7)),
             1e-15);
}

TEST_CASE("an Eigen array is a state too") {
  Eigen::ArrayXd y = Eigen::ArrayXd::LinSpaced(3, 1, 2);
  Dynamic z = y.matrix();
  PhiStepper a{y, [](const Eigen::ArrayXd& x) -> Eigen::ArrayXd { return -x.cube(); }, forward_euler};
  PhiStepper b{z, [](const Dynamic& x) -> Dynamic { return -x.array().cube(); }, forward_euler};
  for (int n = 0; n < 10; ++n) REQUIRE((a.step(y, 0, 0.1) && b.step(z, 0, 0.1)));
  CHECK(distance(y.matrix(), z) <= 1e-15);
}

TEST_CASE("a vector of one's own structs is stepped in place, and nothing else in it is touched") {
  struct Particle {
    double x[3], v[3], m;
  };
  std::vector<Particle> particles{{{0.3, -0.7, 0.2}, {0.5, 0.1, -0.4}, 42}, {{1.1, 0.4, -0.6}, {0.2, -0.3, 0.6}, 43}};
  const auto columns = [&](double* first) {
    return Structs(first, 3, 2, Eigen::OuterStride<>(sizeof(Particle) / sizeof(double)));
  };
  Motion state{columns(particles[0].x), columns(particles[0].v)};
  PhiStepper stepper{state, Pull{}, velocity_verlet};
  for (int n = 0; n < 20; ++n) REQUIRE(stepper.step(state, 0, 0.1));
  const Eigen::VectorXd expected = run<SecondOrder<Dynamic>>(Pull{}, velocity_verlet);
  for (std::size_t p = 0; p < 2; ++p) {
    for (std::size_t a = 0; a < 3; ++a) {
      CHECK(particles[p].x[a] == expected[static_cast<Eigen::Index>(3 * p + a)]);
      CHECK(particles[p].v[a] == expected[static_cast<Eigen::Index>(6 + 3 * p + a)]);
    }
    CHECK(particles[p].m == 42 + static_cast<double>(p));
  }
}

TEST_CASE("columns of a matrix are a motion") {
  Eigen::Matrix<double, 6, 2> phase;
  for (int k = 0; k < 6; ++k)
    phase(k, 0) = positions[static_cast<std::size_t>(k)], phase(k, 1) = velocities[static_cast<std::size_t>(k)];
  auto r = phase.col(0);
  auto v = phase.col(1);
  Motion state{r, v};
  PhiStepper stepper{state, Pull{}, velocity_verlet};
  for (int n = 0; n < 20; ++n) REQUIRE(stepper.step(state, 0, 0.1));
  CHECK(same_bits(phase.reshaped(), run<SecondOrder<Dynamic>>(Pull{}, velocity_verlet)));
}

TEST_CASE("views that share memory are refused, those that stand between each other's numbers are not") {
  std::vector<double> memory(64, 0.5);
  double* const at = memory.data();
  const auto make = [](auto state, auto force) {
    PhiStepper stepper{state, force, velocity_verlet};
    return stepper.step(state, 0, 0.1).outcome();
  };
  const auto refused = [&](auto state, auto force) {
    CHECK_THROWS_WITH(make(state, force), contains("share memory"));
    CHECK(memory == std::vector<double>(64, 0.5));
  };
  const auto fine = [&](auto state, auto force) { CHECK(make(state, force) == Outcome::success); };
  refused(Motion{Mapped(at, 6), Mapped(at, 6)}, Pull{});
  refused(Motion{Mapped(at, 6), Mapped(at + 5, 6)}, Pull{});
  refused(Motion{Mapped(at + 3, 6), Mapped(at, 6)}, Pull{});
  refused(Motion{Strided(at, 6), Strided(at + 2, 6)}, Pull{});
  refused(Motion{Structs(at, 3, 2, Eigen::OuterStride<>(7)), Structs(at + 2, 3, 2, Eigen::OuterStride<>(7))}, Pull{});
  refused(Motion{Structs(at, 3, 2, Eigen::OuterStride<>(2)), Structs(at + 32, 3, 2, Eigen::OuterStride<>(3))}, Pull{});

  fine(Motion{Mapped(at, 6), Mapped(at + 6, 6)}, Pull{});
  fine(Motion{Strided(at, 6), Strided(at + 1, 6)}, Pull{});
  fine(Motion{Structs(at, 3, 2, Eigen::OuterStride<>(7)), Structs(at + 3, 3, 2, Eigen::OuterStride<>(7))}, Pull{});
  // A stepper made for views of one size is made anew for those of another.
  Motion<Mapped> state{Mapped(at, 2), Mapped(at + 2, 2)};
  const auto pull = [](const Dynamic& r) -> Dynamic { return -r; };
  PhiStepper stepper{state, pull, velocity_verlet};
  REQUIRE(stepper.step(state, 0, 0.1));
  new (&state.r) Mapped(at, 3);
  new (&state.v) Mapped(at + 2, 3);
  CHECK_THROWS_WITH(stepper.step(state, 0, 0.1), contains("share memory"));
}

TEST_CASE("a view of a view's memory moves with its stepper's failures: never") {
  SecondOrder<Strided> c;
  const auto before = c.home_r.memory;
  PhiStepper stepper{c.state, [](const Dynamic& r) -> Dynamic { return r * std::nan(""); }, velocity_verlet};
  CHECK_FALSE(stepper.step(c.state, 0, 0.1));
  CHECK(c.home_r.memory == before);
}

TEST_CASE("a user's own coupled state: motion and heat in one solve") {
  // Without coupling to T the motion must be that of a plain Motion.
  struct Uncoupled {
    void add(double, const Warm& y, Warm::Rate& out) const {
      for (Eigen::Index k = 0; k < 6; ++k) out.force[k] += pull(y.r[k], y.r[(k + 3) % 6]);
      out.heat -= 2 * y.T;
    }
  };
  const Eigen::VectorXd both = run<Coupled>(Uncoupled{}, forward_euler);
  CHECK(distance(both.head(12), run<SecondOrder<Dynamic>>(Pull{}, forward_euler)) <= 2e-15);
  CHECK(both[12] == Approx(1.5 * std::pow(1 - 0.2, 20)).epsilon(1e-12));
  CHECK(both[13] == both[12]);
}

TEMPLATE_TEST_CASE("float, double and long double take the same steps, each to its precision", "", float, long double) {
  using V = Eigen::Matrix<TestType, 2, 1>;
  Motion<V> y{V{1, 2}, V{0, 0}};
  PhiStepper stepper{y, [](const V& r) -> V { return -r; }, velocity_verlet, mass(2)};
  for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(y, static_cast<TestType>(n) / 10, TestType(1) / 10));
  CHECK(std::abs(static_cast<double>(y.v.squaredNorm() + y.r.squaredNorm() / 2) - 2.5) <= 2e-3);
}

#elif PHISTEP_FULL
// The contract of a state, in every shape.

TEMPLATE_TEST_CASE("every shape of a first-order state gives the same trajectory", "", Fixed, Columns, FixedColumns,
                   RowMajor, Mapped, Strided, Structs, Reference) {
  check_first_order<TestType>(forward_euler, 0);
}

TEMPLATE_TEST_CASE("every shape of a motion gives the same trajectory", "", Fixed, Columns, FixedColumns, RowMajor,
                   Mapped, Strided, Structs, Reference) {
  check_motion<TestType>(Pull{}, velocity_verlet, 0);
}

#endif
