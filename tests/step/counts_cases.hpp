#pragma once

// What the quick and the full half of step/counts share.
#include <phistep/phistep.hpp>

#include <cmath>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;

namespace counts_cases {

inline constexpr int n = 20;  // steps

/// Calls that really happen, beside those that the statistics claim.
struct Counted {
  int* calls;
  template <class V>
  V operator()(const V& r) const {
    ++*calls;
    return -4 * r;
  }
};
struct CountedDamped {
  int* calls;
  template <class V>
  V operator()(const V& r, const V& v) const {
    ++*calls;
    return -4 * r - 0.3 * v;
  }
};
struct WithJacobian : Counted {
  template <class V>
  auto jacobian(const V& r) const {
    using Square = Eigen::Matrix<double, V::RowsAtCompileTime, V::RowsAtCompileTime>;
    return Square(-4 * Square::Identity(r.size(), r.size()));
  }
};

template <class V>
Motion<V> start_of() {
  return {Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 0.5)};
}

/// n steps by hand.
template <class State, class F, class... More>
Statistics by_hand(State y, F force, auto scheme, const More&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  for (int k = 0; k < n; ++k) REQUIRE(stepper.step(y, 0.01 * k, 0.01));
  CHECK(stepper.statistics().steps == n);
  return stepper.statistics();
}
/// n steps by integrate.
template <class State, class F, class... More>
Statistics by_integrate(State y, F force, auto scheme, const More&... more) {
  PhiStepper stepper{y, force, scheme, more...};
  const RunReport report = integrate(stepper, y, {0, 0.01 * n}, fixed(0.01));
  REQUIRE(report);
  CHECK(report.statistics.steps == n);
  return report.statistics;
}

struct Driven {
  static constexpr bool uses_velocity = false;
  void add(double t, const auto& y, auto& out) const { out.force.array() += std::sin(t) - y.r.array(); }
};

struct NoTangent : ForceTerm {
  static constexpr bool uses_velocity = false, uses_time = false;
  void add(double, const auto& y, auto& out) const { out.force -= 4 * y.r; }
};

}  // namespace counts_cases
