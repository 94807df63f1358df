// The same problem in units of 2^±300: velocities are then up to 2^±600, and squares of them no numbers at all. Nothing
// may change: no bit, no counter. What is squared must have lost its unit before. Whole runs, Radau and springs: the
// full tier.
#include <phistep/krylov.hpp>

#include <functional>
#include <vector>

#include "accuracy/units.hpp"
#include "support/catch.hpp"

using namespace phistep;
using namespace in_units;

namespace {

using Force = std::function<Vec(const Vec&, const Vec&, double)>;

/// Of those in which every number of the problems can be written.
const std::vector<Units> far{{300, 0, 0},       {-300, 0, 0},     {0, 300, 0},    {0, -300, 0},
                             {0, 0, 300},       {0, 0, -300},     {300, 300, 0},  {-300, -300, 0},
                             {400, -100, -150}, {-400, 100, 150}, {300, 0, -220}, {-300, 0, 220}};
const auto chain = [](const Units& u) {
  return Force{[f = Chain{u}](const Vec& r, const Vec& v, double t) -> Vec { return f.all(r, v, t); }};
};
[[maybe_unused]] const auto to_rounding = [](const Units&) { return newton(); };

/// n steps of dt, then on to the time 2 in steps of the run's own choice.
void check_motion(auto scheme, auto&& force, auto&& solver, double dt, int n) {
  check_all(
      [&](const Units& u) {
        Scene scene{u};
        PhiStepper stepper{scene.y, force(u), scheme, mass(scene.masses), solver(u)};
        Result result = march(stepper, scene, dt, n);
        const auto report = integrate(stepper, scene.y, {0.0, u.of(2, 0, 0, 1)}, tolerance{.rtol = 1e-4});
        return Result{result.outcome + ", " + describe(report.outcome), scene.numbers(), stepper.statistics()};
      },
      far);
}

}  // namespace

#if PHISTEP_QUICK

TEST_CASE("units of 2^300: products with the matrix") {
  check_all(
      [](const Units& u) {
        Scene scene{u};
        PhiStepper stepper{scene.y, chain(u), trapezoidal, mass(scene.masses), newton<MatrixFree<>>()};
        return march(stepper, scene, 0.1, 10);
      },
      far);
}

#elif PHISTEP_FULL
// The same problem in units of 2^±300, by the dearer schemes.

TEST_CASE("units of 2^300: radau") { check_motion(radau, chain, to_rounding, 0.1, 10); }
TEST_CASE("units of 2^300: products with the matrix") {
  check_motion(
      trapezoidal, chain, [](const Units&) { return newton<MatrixFree<>>(); }, 0.1, 10);
}
TEST_CASE("units of 2^300: networks of springs") {
  check_all(
      [&](const Units& u) {
        Net net{u};
        PhiStepper stepper{net.y, spring_network<3>(net.springs) + net.gravity(), backward_euler, mass(net.masses)};
        return march(stepper, net, 0.02, 10);
      },
      far);
}

#endif
