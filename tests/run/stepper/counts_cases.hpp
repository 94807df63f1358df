#pragma once

// What the quick and the full half of run/stepper/counts share.
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

/// Instantiating any part of a solver with it is an error: proof that φ = 0 doesn't.
struct NoSolver {
  NoSolver() = delete;
};
template <class V>
struct HardErrorJacobian {
  V operator()(const V& y) const { return -y; }
  template <class W>
  Eigen::MatrixXd jacobian(const W&) const {
    static_assert(!sizeof(W), "a Jacobian was instantiated");
    return {};
  }
};

/// `stiff` decays to 1e-3, at a rate of 1e8.
template <class V>
void check_kept_factors(const V& ones, const auto& stiff) {
  // With the old factors, corrections shrink by θ = |1 − s·1.25|, s = 2/(1 + 1.25): 1/9; unscaled 1/4.
  const auto iterations = [&](double second_dt) {
    V y = 1e-3 * ones;
    PhiStepper stepper{y, stiff, backward_euler, newton({.rtol = 1e-6, .atol = 1e-12})};
    y = 1.001e-3 * ones;
    REQUIRE(stepper.step(y, 0, 1.0));
    y = 1.001e-3 * ones;
    const Statistics before = stepper.statistics();
    const StepReport report = stepper.step(y, 0, second_dt);
    REQUIRE(report);
    CHECK(std::abs(y[0] - 1e-3) <= 1e-9);  // a relative 1e-6
    const Statistics s = stepper.statistics() - before;
    CHECK(s.jacobians == 0);
    CHECK(s.factorizations == (second_dt > 1.3 ? 1 : 0));
    return report.iterations();
  };
  CHECK(iterations(1.0) == 2);
  CHECK(iterations(1.5) == 2);  // new factors of the old Jacobian
  const int kept = iterations(1.25);
  CAPTURE(kept);
  CHECK(kept <= 6);  // 1e5 to go at 1/9 each
}

void check_carried(auto scheme) {
  const Eigen::Matrix2d M = (Eigen::Matrix2d() << 4, 1, 1, 3).finished();
  Motion<Eigen::Vector2d> a{Eigen::Vector2d(1, -0.5), Eigen::Vector2d(0, 0.3)}, b = a;
  const auto force = [](const Eigen::Vector2d& r) -> Eigen::Vector2d { return -3 * r; };
  PhiStepper carries{a, force, scheme, mass(M)};
  for (int k = 0; k < 3; ++k) {
    PhiStepper fresh{b, force, scheme, mass(M)};
    REQUIRE(carries.step(a, 0.1 * k, 0.1));
    REQUIRE(fresh.step(b, 0.1 * k, 0.1));
  }
  CHECK(a.r == b.r);
  CHECK(a.v == b.v);
}

inline void check_linear(const Statistics& s) {
  CHECK(s.jacobians == 1);
  CHECK(s.factorizations == 1);
  CHECK(s.analyses == 0);
  CHECK(s.solves == s.iterations);
  CHECK(s.iterations <= 2 * n + 1);
}

template <class State>
void check_new_dt(State y, auto scheme) {
  int calls = 0;
  PhiStepper stepper{y, WithJacobian{{&calls}}, scheme};
  for (const double dt : {0.1, 0.1, 0.2, 0.2, 0.1}) REQUIRE(stepper.step(y, 0, dt));
  CHECK(stepper.statistics().jacobians == 1);
  CHECK(stepper.statistics().factorizations == 3);
}

template <class State>
void check_reports(State y, auto scheme) {
  int calls = 0;
  PhiStepper stepper{y, WithJacobian{{&calls}}, scheme};
  std::int64_t iterations = 0;
  for (int k = 0; k < 5; ++k) iterations += stepper.step(y, 0, 0.1).iterations();
  CHECK(iterations == stepper.statistics().iterations);
  CHECK(stepper.statistics().force_calls == calls);
}

template <class State>
void check_verlet(const State& start) {
  int calls = 0;
  CHECK(by_integrate(start, Counted{&calls}, velocity_verlet) == Statistics{.steps = n, .force_calls = n + 1});
  CHECK(calls == n + 1);
  calls = 0;
  CHECK(by_hand(start, Counted{&calls}, velocity_verlet) == Statistics{.steps = n, .force_calls = n + 1});
  CHECK(calls == n + 1);
}

}  // namespace counts_cases
