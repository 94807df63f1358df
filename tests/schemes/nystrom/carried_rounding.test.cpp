// Compensated sums: long runs at rounding level, states that were edited, restarts.
#include <phistep/phistep.hpp>

#include <algorithm>
#include <cmath>

#include "contract/states.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "support/catch.hpp"
#if PHISTEP_FULL
#include "contract/restart.hpp"
#endif

using namespace phistep;
using Vec = Eigen::VectorXd;

namespace carried_rounding_cases {

struct Anharmonic : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(auto, const auto& y, auto& out) const { out.force -= 2 * y.r + y.r.cwiseProduct(y.r).cwiseProduct(y.r); }
};
inline Motion<Vec> six() {
  return {Eigen::Map<const Vec>(states::positions.data(), 6), Eigen::Map<const Vec>(states::velocities.data(), 6)};
}

}  // namespace carried_rounding_cases

using namespace carried_rounding_cases;

#if PHISTEP_QUICK

TEST_CASE("compensated sums: a hundred thousand steps of rounding, undone") {
  // 1000 orbits of 100 steps, of which the method itself loses 1e-15 in energy. Plain sums walk: √1e5 roundings of 1.1e-16 in
  // r and in v. Compensated, what is left are roundings of the increments, which are 1/16 of r and v.
  const problems::Kepler kepler{0.1};
  const auto energy = [](const auto& y) { return y.v.squaredNorm() / 2 - 1 / y.r.norm(); };
  const auto worst = [&](auto scheme) {
    auto y = kepler.start();
    PhiStepper stepper{y, kepler, scheme};
    const double h = problems::Kepler::period / 100, before = energy(y);
    double most = 0;
    for (int n = 0; n < 100000; ++n) {
      problems::step(stepper, y, n * h, h);
      if (n % 1000 == 999) most = std::max(most, std::abs(energy(y) / before - 1));
    }
    return most;
  };
  const double plain = worst(rkn1210), compensating = worst(compensated(rkn1210));
  CAPTURE(plain, compensating);
  CHECK(compensating <= 8e-15);
  CHECK(compensating <= plain / 2);
}

TEST_CASE("compensated sums: what was lost belongs to that state alone") {
  auto y = six();
  PhiStepper used{y, Anharmonic{}, compensated(rkn86)};
  for (int n = 0; n < 10; ++n) problems::step(used, y, 0.1 * n, 0.1);
  auto other = six();
  other.v *= 1e-200;
  auto same = other;
  PhiStepper fresh{same, Anharmonic{}, compensated(rkn86)};
  problems::step(used, other, 0.0, 0.1);
  problems::step(fresh, same, 0.0, 0.1);
  CHECK(states::same_bits(states::numbers(other), states::numbers(same)));
}

#elif PHISTEP_FULL
// Compensated sums: restarts.

TEST_CASE("a restart gives the same bits") {
  const auto steps = [](auto scheme) {
    return [=](const auto& y) { return PhiStepper{y, Anharmonic{}, scheme, mass(2.0)}; };
  };
  restart::check({0.05, false}, six, steps(rkn86));
  restart::check({0.05}, six, steps(compensated(rkn1210)));
}

#endif
