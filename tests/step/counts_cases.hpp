#pragma once

// What the quick and the full half of step/counts share.
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstdint>

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

inline void check_linear(const Statistics& s) {
  CHECK(s.jacobians == 1);
  CHECK(s.factorizations == 1);
  CHECK(s.analyses == 0);
  CHECK(s.solves == s.iterations);
  CHECK(s.iterations <= 2 * n + 1);
}

template <class V>
void check_new_dt(auto scheme) {
  int calls = 0;
  auto y = start_of<V>();
  PhiStepper stepper{y, WithJacobian{{&calls}}, scheme};
  for (const double dt : {0.1, 0.1, 0.2, 0.2, 0.1}) REQUIRE(stepper.step(y, 0, dt));
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 3);
}

template <class V>
void check_report(auto scheme) {
  auto y = start_of<V>();
  int calls = 0;
  PhiStepper stepper{y, WithJacobian{{&calls}}, scheme};
  std::int64_t iterations = 0;
  for (int k = 0; k < 5; ++k) iterations += stepper.step(y, 0, 0.1).iterations();
  CHECK(iterations == stepper.statistics().iterations);
  CHECK(stepper.statistics().force_calls == calls);
}

template <class V>
void check_verlet() {
  int calls = 0;
  CHECK(by_integrate(start_of<V>(), Counted{&calls}, velocity_verlet) == Statistics{.steps = n, .force_calls = n + 1});
  CHECK(calls == n + 1);
  calls = 0;
  CHECK(by_hand(start_of<V>(), Counted{&calls}, velocity_verlet) == Statistics{.steps = n, .force_calls = n + 1});
  CHECK(calls == n + 1);
}

}  // namespace counts_cases
