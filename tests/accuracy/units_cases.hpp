#pragma once

// What both halves of accuracy/units need: the systems of units, and a chain as a force of each kind.

#include <phistep/phistep.hpp>

#include <functional>
#include <vector>

#include "accuracy/units.hpp"
#include "support/catch.hpp"
#include "support/shared_force.hpp"

using namespace phistep;
using namespace in_units;

namespace {

const std::vector<Units> others{{20, 0, 0},     {0, -20, 0},   {0, 0, 20},   {-33, 0, 0},  {0, 41, 0},     {0, 0, -60},
                                {-20, 40, -31}, {60, -60, 20}, {-60, 21, 7}, {37, 60, 60}, {-40, -40, -40}};

[[maybe_unused]] void check_all(const std::function<Result(const Units&)>& run, int line = __builtin_LINE()) {
  in_units::check_all(run, others, line);
}
/// A motion under force(units), by scheme and solver(units).
void check_motion(auto scheme, auto&& force, auto&& solver, double dt, int n, int line = __builtin_LINE()) {
  const auto run = [&](const Units& u) {
    Scene scene{u};
    PhiStepper stepper{scene.y, force(u), scheme, mass(scene.masses), solver(u)};
    return march(stepper, scene, dt, n);
  };
  check_all(run, line);
}
[[maybe_unused]] const auto to_rounding = [](const Units&) { return newton(); };
[[maybe_unused]] const auto to_tolerance = [](const Units& u) {
  return newton({.rtol = 1e-4, .atol = u.of(1e-5, 1, 0, -1)});
};
[[maybe_unused]] const auto chain = [](const Units& u) -> shared_force::OfMotionAndTime<Vec> {
  return [f = Chain{u}](const Vec& r, const Vec& v, double t) -> Vec { return f.all(r, v, t); };
};
[[maybe_unused]] const auto tangent_chain = [](const Units& u) { return ChainWithJacobian{u}; };
[[maybe_unused]] const auto elastic_chain = [](const Units& u) -> shared_force::OfState<Vec> {
  return [f = Chain{u}](const Vec& r) -> Vec { return f.elastic(r); };
};

void check_from_rest(auto scheme) {
  check_all([scheme](const Units& u) {
    Scene scene{u};
    scene.y.r.setZero();
    scene.y.v.setZero();
    PhiStepper stepper{scene.y, chain(u), scheme, mass(scene.masses)};
    const auto report = integrate(stepper, scene.y, {0.0, u.of(3, 0, 0, 1)},
                                  tolerance{.rtol = 1e-4, .atol = {u.of(1e-5, 1, 0, 0), u.of(1e-4, 1, 0, -1)}});
    return Result{describe(report.outcome), scene.numbers(), report.statistics};
  });
}

}  // namespace
