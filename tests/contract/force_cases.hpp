#pragma once

// One force in many forms, and ten steps with each.

#include <phistep/phistep.hpp>

#include <cmath>

#include "contract/states.hpp"
#include "support/catch.hpp"

namespace force_cases {

using namespace phistep;
using states::distance;
using states::numbers;
using Vec = Eigen::VectorXd;

inline constexpr double k = 3.0, c = 0.4;

/// Ten steps of every kind of scheme: explicit, Verlet, Newton.
struct Steps {
  Vec explicit_, verlet, newton;
  Statistics newton_counts;
};
inline void check_step(const StepReport& step) { REQUIRE(step); }
Statistics step_ten(const auto& force, auto scheme, Vec& out) {
  states::SecondOrder<Vec> s;
  PhiStepper stepper{s.state, force, scheme};
  for (int n = 0; n < 10; ++n) check_step(stepper.step(s.state, 0.1 * n, 0.1));
  out = numbers(s.state);
  return stepper.statistics();
}
template <class F>
Steps steps(const F& force) {
  Steps result;
  step_ten(force, forward_euler, result.explicit_);
  step_ten(force, velocity_verlet, result.verlet);
  result.newton_counts = step_ten(force, trapezoidal, result.newton);
  return result;
}
inline void check_same(const Steps& a, const Steps& b) {
  CHECK(distance(a.explicit_, b.explicit_) <= 1e-14);
  CHECK(distance(a.verlet, b.verlet) <= 1e-13);
  CHECK(distance(a.newton, b.newton) <= 1e-12);
}
/// Of forms of f(r): the scheme that solves nothing, to be compiled for many of them.
template <class F>
Vec verlet(const F& force) {
  Vec out;
  step_ten(force, velocity_verlet, out);
  return out;
}
inline void check_same(const Vec& a, const Vec& b) { CHECK(distance(a, b) <= 1e-13); }

inline const auto pull = [](const Vec& r) -> Vec { return -k * r; };
inline const auto damped = [](const Vec& r, const Vec& v) -> Vec { return -k * r - c * v; };
inline const auto driven = [](const Vec& r, const Vec& v, double t) -> Vec {
  return (-k * r - c * v).array() + std::sin(t);
};

struct Adding : ForceTerm {
  static constexpr bool uses_time = false;
  void add(double, const auto& y, auto& out) const { out.force -= k * y.r + c * y.v; }
};
struct AddingTimed {
  void add(double t, const auto& y, auto& out) const {
    out.force.array() += (-k * y.r - c * y.v).array() + std::sin(t);
  }
};
struct WithJacobian {
  Vec operator()(const Vec& r, const Vec& v) const { return -k * r - c * v; }
  MotionJacobian<Eigen::MatrixXd> jacobian(const Vec& r, const Vec&) const {
    const auto I = Eigen::MatrixXd::Identity(r.size(), r.size());
    return {-k * I, -c * I};
  }
};

}  // namespace force_cases
