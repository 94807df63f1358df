// SRKN6b and SRKN11b: order, counts, symmetry, energy over long times, restarts; and order 8 by composition of a scheme.
#include <phistep/phistep.hpp>

#include <cmath>
#include <limits>

#include "contract/restart.hpp"
#include "contract/states.hpp"
#include "convergence/observed_order.hpp"
#include "problems/driven_motion.hpp"
#include "problems/forced.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"

using namespace phistep;
using convergence::check_order;
using convergence::errors;
using problems::distance;
using problems::march;
using Vec = Eigen::VectorXd;

namespace {

template <class T, class Scheme>
double error_at_end(Scheme scheme, int steps) {
  using Problem = problems::DrivenMotion<T>;
  const auto y = Problem::exact(0);
  PhiStepper stepper{y, Problem{}, scheme, mass(T(Problem::mass))};
  return distance(march(stepper, y, T(0), T(3), steps), Problem::exact(3));
}

struct Anharmonic : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(auto, const auto& y, auto& out) const { out.force -= 2 * y.r + y.r.cwiseProduct(y.r).cwiseProduct(y.r); }
};
/// A magnetic field that grows with the distance, perpendicular to the plane, and a pull: no energy is lost.
template <class T>
struct Magnetic {
  using Vector = Eigen::Matrix<T, 2, 1>;
  Vector operator()(const Vector& r, const Vector& v) const {
    const T B = 1 + r.squaredNorm();
    return Vector{-2 * r[0] + B * v[1], -2 * r[1] - B * v[0]};
  }
};
struct LateTrouble : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = true;
  void add(double t, const auto& y, auto& out) const {
    out.force -= y.r;
    if (t > 0.15) out.force[3] = std::numeric_limits<double>::quiet_NaN();
  }
};
Motion<Vec> six() {
  return {Eigen::Map<const Vec>(states::positions.data(), 6), Eigen::Map<const Vec>(states::velocities.data(), 6)};
}
template <class T>
Motion<Eigen::Matrix<T, 2, 1>> two() {
  return {{T(1), T(0.25)}, {T(0), T(0.75)}};
}

}  // namespace

TEST_CASE("orders 4, 6 and 8 in long double") {
  check_order(errors(60, [](int n) { return error_at_end<long double>(srkn6b, n); }), 4, 0.05);
  check_order(errors(10, [](int n) { return error_at_end<long double>(srkn11b, n); }), 6, 0.05);
  check_order(errors(10, [](int n) { return error_at_end<long double>(composed(velocity_verlet), n); }), 8, 0.1);
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
  using Forced = problems::ForcedMotion<L>;
  const auto error = [](int n) {
    PhiStepper stepper{Forced::exact(0), Forced{}, composed(velocity_verlet), mass(static_cast<L>(Forced::mass))};
    return distance(march(stepper, Forced::exact(0), L(0), L(2), n), Forced::exact(2));
  };
  CHECK(std::abs(std::log2(error(20) / error(40)) - 8) <= 0.4);
}

TEST_CASE("order 8 for a first-order state, by the midpoint rule") {
  using Flow = problems::ForcedFlow<>;
  const auto error = [](int n) {
    PhiStepper stepper{Flow::exact(0), Flow{}, composed(midpoint), capacity(Flow::capacity)};
    return distance(march(stepper, Flow::exact(0), 0.0, 2.0, n), Flow::exact(2));
  };
  CHECK(std::abs(std::log2(error(8) / error(16)) - 8) <= 0.6);
}

TEST_CASE("force calls: six, eleven, seventeen a step, and one more at the start of a run") {
  const auto calls = [](auto scheme, int steps) {
    auto y = six();
    PhiStepper stepper{y, Anharmonic{}, scheme};
    for (int n = 0; n < steps; ++n) problems::step(stepper, y, 0.1 * n, 0.1);
    return stepper.statistics().force_calls;
  };
  CHECK(calls(srkn6b, 10) == 6 * 10 + 1);
  CHECK(calls(srkn11b, 10) == 11 * 10 + 1);
  CHECK(calls(composed(velocity_verlet), 10) == 17 * 10 + 1);
}

TEST_CASE("symmetric: a step there and back is none, to rounding") {
  const auto check = [](auto scheme, auto force, auto start) {
    auto y = start;
    PhiStepper stepper{y, force, scheme};
    problems::step(stepper, y, 0.0, 0.2);
    CHECK(distance(y, start) > 0.01);
    problems::step(stepper, y, 0.2, -0.2);
    // Up to 36 kicks and drifts, a rounding of numbers near 1 each, magnified by less than 2.
    CHECK(distance(y, start) <= 36 * 2 * 1.2e-16);
  };
  check(srkn6b, Anharmonic{}, six());
  check(srkn11b, Anharmonic{}, six());
  check(composed(velocity_verlet), Anharmonic{}, six());
  check(composed(velocity_verlet), Magnetic<double>{}, two<double>());
}

TEST_CASE("symplectic: the energy of five thousand orbits doesn't drift") {
  const problems::Kepler kepler{0.2};
  const auto energy = [](const auto& y) { return y.v.squaredNorm() / 2 - 1 / y.r.norm(); };
  const auto worst = [&](auto scheme, int steps) {  // in the first tenth, and over all
    auto y = kepler.start();
    PhiStepper stepper{y, kepler, scheme};
    // Not a whole number of steps an orbit: else the phase at which they fall would creep.
    const double h = problems::Kepler::period / (steps + 0.37), before = energy(y);
    double early = 0, all = 0;
    for (int n = 0; n < 5000 * steps; ++n) {
      problems::step(stepper, y, n * h, h);
      all = std::max(all, std::abs(energy(y) / before - 1));
      if (n < 500 * steps) early = all;
    }
    CHECK(all <= 1.1 * early);
    return all;
  };
  CHECK(worst(srkn6b, 20) <= 3e-4);
  CHECK(worst(srkn11b, 12) <= 3e-4);
}

TEST_CASE("masses: none, one, one a component, a matrix") {
  const auto go = [](auto... m) { return march(PhiStepper{six(), Anharmonic{}, srkn11b, m...}, six(), 0.0, 2.0, 20); };
  const auto one = go(), two = go(mass(2.0));
  CHECK(distance(one, go(mass(Eigen::MatrixXd(Eigen::MatrixXd::Identity(6, 6))))) <= 1e-13);
  CHECK(distance(two, go(mass(Vec(Vec::Constant(6, 2.0))))) <= 1e-13);
  CHECK(distance(two, go(mass(Eigen::MatrixXd(2 * Eigen::MatrixXd::Identity(6, 6))))) <= 1e-13);
  CHECK(distance(one, two) > 0.1);
}

TEST_CASE("float reaches its rounding") {
  CHECK(error_at_end<float>(srkn6b, 100) <= 100 * 1.2e-7 * 10);
  CHECK(error_at_end<float>(srkn11b, 20) <= 100 * 1.2e-7 * 10);
}

TEST_CASE("under a tolerance, by step doubling") {
  auto y = problems::Kepler{}.start();
  PhiStepper stepper{y, problems::Kepler{}, composed(velocity_verlet)};
  const RunReport run = integrate(stepper, y, {0, 2 * problems::Kepler::period}, tolerance{.rtol = 1e-9});
  REQUIRE(run);
  // κ of two such orbits is about 400.
  CHECK(distance(y, problems::Kepler{}.exact(0)) <= 10 * 400 * 1e-9);
}

TEST_CASE("a force that isn't finite leaves the state as it was") {
  const auto check = [](auto scheme, auto force) {
    auto y = six();
    const auto before = restart::bytes(y);
    PhiStepper stepper{y, force, scheme};
    const StepReport report = stepper.step(y, 0.0, 0.2);
    CHECK(report.outcome() == Outcome::non_finite_force);
    CHECK(restart::bytes(y) == before);
  };
  check(srkn11b, LateTrouble{});
  check(composed(velocity_verlet), LateTrouble{});
  check(composed(velocity_verlet), [](const Vec& r, const Vec& v, double t) -> Vec {
    if (t > 0.1) return r / 0.0;
    return -r - 0.1 * v;
  });
}

TEST_CASE("a restart gives the same bits") {
  const auto steps = [](auto force, auto scheme) {
    return [=](const auto& y) { return PhiStepper{y, force, scheme}; };
  };
  restart::check({0.05, false}, six, steps(Anharmonic{}, srkn6b));
  restart::check({0.05}, six, steps(Anharmonic{}, srkn11b));
  restart::check({0.05, false}, six, steps(Anharmonic{}, composed(velocity_verlet)));
  restart::check({0.05, false}, six, steps(states::DampedPull{}, composed(velocity_verlet)));
}
