// The contract of a state: the same numbers give the same steps in every shape, and views are stepped in place.
#include <phistep/phistep.hpp>

#include <cmath>
#include <vector>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace states;

namespace {

template <class Case>
Eigen::VectorXd run(auto force, auto scheme) {
  Case c;
  PhiStepper stepper{c.state, force, scheme};
  for (int n = 0; n < 20; ++n) {
    const StepReport step = stepper.step(c.state, 0.1 * n, 0.1);
    INFO(step.message());
    REQUIRE(step);
  }
  return numbers(c.state);
}

// Explicit schemes must agree to the bit; implicit ones up to rounding (the order of the unknowns may differ).
template <class V>
void check_first_order(auto scheme, double tolerance) {
  CHECK(distance(run<FirstOrder<V>>(DrivenPull{}, scheme), run<FirstOrder<Dynamic>>(DrivenPull{}, scheme)) <=
        tolerance);
}
template <class V>
void check_motion(auto force, auto scheme, double tolerance) {
  CHECK(distance(run<SecondOrder<V>>(force, scheme), run<SecondOrder<Dynamic>>(force, scheme)) <= tolerance);
}

}  // namespace

TEMPLATE_TEST_CASE("every shape of a first-order state gives the same trajectory", "", Fixed, Columns, FixedColumns,
                   RowMajor, Mapped, Strided, Structs, Reference) {
  check_first_order<TestType>(forward_euler, 0);
}
TEMPLATE_TEST_CASE("every shape of a motion gives the same trajectory", "", Fixed, Columns, FixedColumns, RowMajor,
                   Mapped, Strided, Structs, Reference) {
  check_motion<TestType>(Pull{}, velocity_verlet, 0);
}
TEMPLATE_TEST_CASE("implicit schemes too", "", Fixed, RowMajor, Strided, Reference) {
  check_first_order<TestType>(phi(0.7), 1e-15);
}
TEMPLATE_TEST_CASE("and implicit schemes of damped motion", "", FixedColumns, Columns, Structs) {
  check_motion<TestType>(DampedPull{}, trapezoidal, 2e-15);
}

TEST_CASE("an Eigen array is a state too") {
  Eigen::ArrayXd y = Eigen::ArrayXd::LinSpaced(3, 1, 2);
  Dynamic z = y.matrix();
  PhiStepper a{y, [](const Eigen::ArrayXd& x) -> Eigen::ArrayXd { return -x.cube(); }, trapezoidal,
               mass(Eigen::Vector3d(1, 2, 3))};
  PhiStepper b{z, [](const Dynamic& x) -> Dynamic { return -x.array().cube(); }, trapezoidal,
               mass(Eigen::Vector3d(1, 2, 3))};
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
  const auto check = [](auto scheme, double decay) {
    const Eigen::VectorXd both = run<Coupled>(Uncoupled{}, scheme);
    CHECK(distance(both.head(12), run<SecondOrder<Dynamic>>(Pull{}, scheme)) <= 2e-15);
    CHECK(both[12] == Approx(1.5 * std::pow(decay, 20)).epsilon(1e-12));
    CHECK(both[13] == both[12]);
  };
  check(forward_euler, 1 - 0.2);
  check(trapezoidal, (1 - 0.1) / (1 + 0.1));
  check(midpoint, (1 - 0.1) / (1 + 0.1));
  check(backward_euler, 1 / (1 + 0.2));
}

TEMPLATE_TEST_CASE("float, double and long double take the same steps, each to its precision", "", float, double,
                   long double) {
  using V = Eigen::Matrix<TestType, 2, 1>;
  using D = Eigen::Matrix<TestType, Eigen::Dynamic, 1>;
  const auto oscillator = []<class Vector>(std::type_identity<Vector>, auto scheme) {
    Motion<Vector> y{Vector(2), Vector(2)};
    y.r << 1, 2, y.v << 0, 0;
    PhiStepper stepper{y, [](const Vector& r) -> Vector { return -r; }, scheme, mass(2)};
    for (int n = 0; n < 100; ++n) REQUIRE(stepper.step(y, static_cast<TestType>(n) / 10, TestType(1) / 10));
    // Energy ½·2v² + ½r²: φ = ½ keeps it.
    return static_cast<double>(y.v.squaredNorm() + y.r.squaredNorm() / 2);
  };
  const double u = static_cast<double>(std::numeric_limits<TestType>::epsilon());
  CHECK(std::abs(oscillator(std::type_identity<V>{}, trapezoidal) - 2.5) <= std::max(1000 * u, 1e-15));
  CHECK(std::abs(oscillator(std::type_identity<D>{}, midpoint) - 2.5) <= std::max(1000 * u, 1e-15));
  CHECK(std::abs(oscillator(std::type_identity<V>{}, velocity_verlet) - 2.5) <= 2e-3);
}
