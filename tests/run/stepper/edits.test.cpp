// The state belongs to the user, who may edit it between steps: nothing carried over may then be stale.
#include <cmath>
#include <sstream>

#include "run/stepper/edits_cases.hpp"
#if PHISTEP_QUICK
#include <phistep/io/checkpoint.hpp>

#include "support/shared_force.hpp"
#endif

using namespace edits_cases;

#if PHISTEP_QUICK

using V1 = Eigen::Matrix<double, 1, 1>;
using OfState = shared_force::OfState<V1>;

// Pull knows no velocity: Verlet carries it from step to step.
TEST_CASE("every scheme, dynamic motion: edited states are stepped as by a fresh stepper") {
  check<SecondOrder<Dynamic>>(Pull{}, forward_euler, 0, 17);
  check<SecondOrder<Dynamic>>(Pull{}, symplectic_euler, 0, 17);
  check<SecondOrder<Dynamic>>(Pull{}, symplectic_euler_adjoint, 0, 17);
}
TEST_CASE("every scheme, fixed motion") {
  check<SecondOrder<Fixed>>(Pull{}, phi(0.7), 1e-12, 17);
  check<SecondOrder<Fixed>>(Pull{}, tr_bdf2, 1e-12, 17);
}
TEST_CASE("first order") { check<FirstOrder<Dynamic>>(DrivenPull{}, forward_euler, 0, 11); }

TEST_CASE("Verlet to the bit: fixed, dynamic and mapped") {
  for (const unsigned seed : {1u, 2u, 3u}) {
    check<SecondOrder<Fixed>>(Pull{}, velocity_verlet, 0, seed);
    check<SecondOrder<Mapped>>(Pull{}, velocity_verlet, 0, seed);
  }
}
namespace {
/// A spring that hardens with time.
struct Hardening : ForceTerm {
  static constexpr bool uses_velocity = false;
  static void add(double t, const auto& at, auto& out) { out.force -= (1 + t) * at.r; }
};
}  // namespace

TEST_CASE("a force that depends on time is not kept for another time") {
  using Plane = Eigen::Vector2d;
  Motion<Plane> y{Plane(1, 2), Plane(0, 1)};
  PhiStepper stepper{y, Hardening{}, velocity_verlet};
  REQUIRE(stepper.step(y, 0, 0.1));
  REQUIRE(stepper.step(y, 0.1, 0.1));
  CHECK(stepper.statistics().force_calls == 3);  // the end of one step is the start of the next
  auto z = y;
  PhiStepper fresh{z, Hardening{}, velocity_verlet};
  REQUIRE(stepper.step(y, 5, 0.1));
  REQUIRE(fresh.step(z, 5, 0.1));
  CHECK((y.r == z.r && y.v == z.v));
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

TEST_CASE("an edit from +0 to -0 is seen, in small states and large ones") {
  check_sign_of_zero<Eigen::Matrix<double, 1, 1>>(velocity_verlet, 1);
  check_sign_of_zero<Eigen::Matrix<double, 3, 1>>(velocity_verlet, 3);
  check_sign_of_zero<Eigen::Matrix<float, 3, 1>>(velocity_verlet, 3);
  check_sign_of_zero<Eigen::Matrix<long double, 2, 1>>(velocity_verlet, 2);
  check_sign_of_zero<Eigen::VectorXd>(velocity_verlet, 3);
}

// States of up to 4096 numbers are kept, of larger ones a fingerprint; a checkpoint leaves a fingerprint of either.
TEST_CASE("one bit of any position is seen, between steps and after a checkpoint") {
  const auto force = [](const Eigen::VectorXd& r) -> Eigen::VectorXd { return -r; };
  for (const Eigen::Index n : {1, 7, 30, 4096, 4097})
    for (const bool saves : {false, true}) {
      Motion y{Eigen::VectorXd::LinSpaced(n, 1, 2).eval(), Eigen::VectorXd::Zero(n).eval()};
      PhiStepper stepper{y, force, velocity_verlet};
      REQUIRE(stepper.step(y, 0, 0.1));
      std::int64_t calls = 2;
      for (const Eigen::Index edited : {Eigen::Index{-1}, Eigen::Index{0}, n / 2, n - 1}) {
        CAPTURE(n, saves, edited);
        if (saves) {
          std::stringstream file;
          save_checkpoint(file, stepper, y);
          load_checkpoint(file, stepper, y);
        }
        if (edited >= 0) y.r[edited] = std::nextafter(y.r[edited], 0.0);
        y.v[0] += 1;  // which this force doesn't see
        auto z = y;
        PhiStepper fresh{z, force, velocity_verlet};
        REQUIRE(stepper.step(y, 0.1, 0.1));
        REQUIRE(fresh.step(z, 0.1, 0.1));
        CHECK((y.r == z.r && y.v == z.v));
        calls += edited >= 0 ? 2 : 1;
        CHECK(stepper.statistics().force_calls == calls);
      }
    }
}

TEST_CASE("an edit that leaves a contact does not meet the contact's tangent") {
  // Stiff for y > 0, soft for y < 0: what was kept from the stiff side must not pass for convergence.
  for (const double stiff : {1e4, 1e8, 1e13, 1e18}) {
    const OfState force = [stiff](const V1& y) -> V1 { return y[0] > 0 ? V1(-stiff * y) : V1(-y); };
    for (const double dt : {0.5, 0.25}) {  // the factors are kept, or made anew from the kept tangent
      V1 y(1);
      PhiStepper stepper{y, force, backward_euler};
      REQUIRE(stepper.step(y, 0, 0.5));
      y[0] = -1;
      REQUIRE(stepper.step(y, 0.5, dt));
      CAPTURE(stiff, dt);
      CHECK(y[0] == Approx(-1 / (1 + dt)).epsilon(1e-6));
    }
  }
}

TEST_CASE("an edit out of the old tangent's range fails no step that a fresh stepper takes") {
  const OfState cubic = [](const V1& y) -> V1 { return -y.array().cube(); };
  V1 y(0.15);
  PhiStepper stepper{y, cubic, backward_euler};
  REQUIRE(stepper.step(y, 0, 0.01));
  y[0] = 40;
  V1 z = y;
  PhiStepper fresh{z, cubic, backward_euler};
  REQUIRE(fresh.step(z, 0, 0.5));
  REQUIRE(stepper.step(y, 0, 0.5));
  CHECK(distance(y, z) <= 1e-12);
}

TEST_CASE("what earlier solves have left makes no step fail that a fresh stepper takes") {
  const auto check = [](const OfState& force, double before, double first_dt, double after, double dt,
                        NewtonOptions options = {}) {
    V1 y(before);
    PhiStepper stepper{y, force, backward_euler, newton(options)};
    REQUIRE(stepper.step(y, 0, first_dt));
    y[0] = after;
    V1 z = y;
    PhiStepper fresh{z, force, backward_euler, newton(options)};
    REQUIRE(fresh.step(z, 1, dt));
    const StepReport report = stepper.step(y, 1, dt);
    INFO(report.message());
    CHECK(report);
    CHECK((!report || distance(y, z) <= 1e-12));
  };
  // The kept Jacobian, +1 for y < 5, makes 1 - dt J = 0.
  check([](const V1& y) -> V1 { return y[0] < 5 ? y : V1(10 - y[0]); }, 1, 0.5, 20, 1);
  // … or throws the iterate out of the logarithm's domain, further than it can be taken back by halves.
  check([](const V1& y) -> V1 { return V1(y[0] > 5 ? -1.0 : -1e6 * std::log(y[0])); }, 10, 1, 2, 1);
  // … or costs corrections, of which a fresh stepper needs all that are allowed.
  for (const int most : {4, 5, 6, 7, 8, 9, 10}) {
    const OfState cubic = [](const V1& y) -> V1 { return -y.array().cube(); };
    V1 y(30);
    PhiStepper probe{y, cubic, backward_euler, newton({.max_iterations = most})};
    if (probe.step(y, 1, 0.5)) check(cubic, 0.15, 0.01, 30, 0.5, {.max_iterations = most});
  }
}

#elif PHISTEP_FULL
// Edited states, every scheme and every kind of state.

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

#endif
