// A symmetric scheme composed to order 8: velocity Verlet with forces that depend on v or not, the midpoint rule.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>

#include "accuracy/observed_order.hpp"
#include "contract/states.hpp"
#include "problems/driven_motion.hpp"
#include "problems/forced.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_FULL
#include "contract/restart.hpp"
#endif

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;
using Vec = Eigen::VectorXd;

namespace composed_cases {

/// A magnetic field that grows with the distance, perpendicular to the plane, and a pull: no energy is lost.
template <class T>
struct Magnetic {
  using Vector = Eigen::Matrix<T, 2, 1>;
  Vector operator()(const Vector& r, const Vector& v) const {
    const T B = 1 + r.squaredNorm();
    return Vector{-2 * r[0] + B * v[1], -2 * r[1] - B * v[0]};
  }
};
inline Motion<Vec> six() {
  return {Eigen::Map<const Vec>(states::positions.data(), 6), Eigen::Map<const Vec>(states::velocities.data(), 6)};
}
template <class T>
Motion<Eigen::Matrix<T, 2, 1>> two() {
  return {{T(1), T(0.25)}, {T(0), T(0.75)}};
}

}  // namespace composed_cases

using namespace composed_cases;

#if PHISTEP_QUICK

TEST_CASE("order 8 in long double, driven") {
  using Problem = problems::DrivenMotion<long double>;
  const auto error = [](int n) {
    PhiStepper stepper{Problem::exact(0), Problem{}, composed(velocity_verlet),
                       mass(static_cast<long double>(Problem::mass))};
    return distance(march(stepper, Problem::exact(0), 0.0L, 3.0L, n), Problem::exact(3));
  };
  check_order(errors(10, error), 8, 0.1);
}

TEST_CASE("order 8 where the force depends on v: in a magnetic field, and driven with friction") {
  using L = long double;
  const auto run = [](int n) {
    return march(PhiStepper{two<L>(), Magnetic<L>{}, composed(velocity_verlet)}, two<L>(), L(0), L(2), n);
  };
  const auto end = run(8 * 24);
  const double coarse = distance(run(12), end), fine = distance(run(24), end);
  CAPTURE(coarse, fine);
  CHECK(std::abs(std::log2(coarse / fine) - 8) <= 0.4);
}

TEST_CASE("order 8 for a first-order state, by the midpoint rule") {
  using Flow = problems::ForcedFlow<>;
  const auto error = [](int n) {
    PhiStepper stepper{Flow::exact(0), Flow{}, composed(midpoint), capacity(Flow::capacity)};
    return distance(march(stepper, Flow::exact(0), 0.0, 2.0, n), Flow::exact(2));
  };
  CHECK(std::abs(std::log2(error(8) / error(16)) - 8) <= 0.6);
}

TEST_CASE("seventeen force calls a step, and one more at the start of a run") {
  auto y = six();
  PhiStepper stepper{y, states::Pull{}, composed(velocity_verlet)};
  for (int n = 0; n < 10; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
  CHECK(stepper.statistics().force_calls == 17 * 10 + 1);
}

TEST_CASE("symmetric: a step there and back is none, to rounding") {
  using L = long double;
  auto y = two<L>();
  PhiStepper stepper{y, Magnetic<L>{}, composed(velocity_verlet)};
  problems::step(stepper, y, 0.0L, 0.2L);
  CHECK(distance(y, two<L>()) > 0.01);
  problems::step(stepper, y, 0.2L, -0.2L);
  // 34 substeps, the longest of 0.56 Δt, each with a few roundings of numbers near 1, magnified by less than 2.
  CHECK(distance(y, two<L>()) <= 34 * 3 * 2 * static_cast<double>(std::numeric_limits<L>::epsilon()) / 2);
}

#elif PHISTEP_FULL
// A scheme composed to order 8: with friction, under a tolerance, restarted.

TEST_CASE("order 8 where the force depends on v: in a magnetic field, and driven with friction") {
  using L = long double;
  const auto run = [](int n) {
    return march(PhiStepper{two<L>(), Magnetic<L>{}, composed(velocity_verlet)}, two<L>(), L(0), L(2), n);
  };
  const auto end = run(8 * 24);
  const double coarse = distance(run(12), end), fine = distance(run(24), end);
  CAPTURE(coarse, fine);
  CHECK(std::abs(std::log2(coarse / fine) - 8) <= 0.4);
  using Forced = problems::ForcedMotion<L>;
  const auto error = [](int n) {
    PhiStepper stepper{Forced::exact(0), Forced{}, composed(velocity_verlet), mass(static_cast<L>(Forced::mass))};
    return distance(march(stepper, Forced::exact(0), L(0), L(2), n), Forced::exact(2));
  };
  CHECK(std::abs(std::log2(error(20) / error(40)) - 8) <= 0.4);
}

TEST_CASE("under a tolerance, by step doubling") {
  auto y = problems::Kepler{}.start();
  PhiStepper stepper{y, problems::Kepler{}, composed(velocity_verlet)};
  const RunReport run = integrate(stepper, y, {0, 2 * problems::Kepler::period}, tolerance{.rtol = 1e-9});
  REQUIRE(run);
  // κ of two such orbits is about 400.
  CHECK(distance(y, problems::Kepler{}.exact(0)) <= 10 * 400 * 1e-9);
}

TEST_CASE("symmetric: a step there and back is none, to rounding") {
  auto y = two<double>();
  PhiStepper stepper{y, Magnetic<double>{}, composed(velocity_verlet)};
  problems::step(stepper, y, 0.0, 0.2);
  CHECK(distance(y, two<double>()) > 0.01);
  problems::step(stepper, y, 0.2, -0.2);
  // 34 substeps, the longest of 0.56 Δt, each with a few roundings of numbers near 1, magnified by less than 2.
  CHECK(distance(y, two<double>()) <= 34 * 3 * 2 * 1.2e-16);
}

TEST_CASE("a force that isn't finite leaves the state as it was") {
  auto y = six();
  const auto before = restart::bytes(y);
  PhiStepper stepper{y,
                     [](const Vec& r, const Vec& v, double t) -> Vec {
                       if (t > 0.1) return r / 0.0;
                       return -r - 0.1 * v;
                     },
                     composed(velocity_verlet)};
  CHECK(stepper.step(y, 0.0, 0.2).outcome() == Outcome::non_finite_force);
  CHECK(restart::bytes(y) == before);
}

TEST_CASE("a restart gives the same bits") {
  restart::check({0.05, false}, six, [](const auto& y) {
    return PhiStepper{y, states::DampedPull{}, composed(velocity_verlet)};
  });
}

#endif
