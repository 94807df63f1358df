#pragma once

// What the quick and the full half of schemes/extrapolation/extrapolated share.
#include <phistep/phistep.hpp>
#include <phistep/schemes/extrapolation/extrapolated.hpp>

#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "problems/dahlquist.hpp"
#include "problems/forced.hpp"
#include "problems/hires.hpp"
#include "problems/kepler.hpp"
#include "problems/march.hpp"
#include "problems/pendulum_flow.hpp"
#include "problems/robertson.hpp"
#include "support/catch.hpp"

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"  // of two kinds, which leave in 0.3

using namespace phistep;
using problems::distance;
using problems::march;
using problems::PendulumFlow;
using Vec = Eigen::VectorXd;

namespace extrapolated_cases {

/// One halving, from both sides: with columns in the numerator, more would leave the range between error constant and rounding.
template <class Error>
void check_order(Error&& error, int n, double order, double tolerance = 0.15) {
  const double coarse = error(n), fine = error(2 * n), observed = std::log2(coarse / fine);
  CAPTURE(n, coarse, fine, observed, order);
  CHECK(std::abs(observed - order) <= tolerance);
}

/// A pendulum with quadratic drag, and its Jacobian by hand: differences would end the order at 1e-8.
template <class T>
struct Pendulum {
  using One = Eigen::Matrix<T, 1, 1>;
  using Two = Eigen::Matrix<T, 2, 1>;
  One operator()(const One& r, const One& v) const {
    using std::sin;
    return One{-2 * sin(r[0]) - v[0] - v[0] * v[0] / 4};
  }
  [[nodiscard]] MotionJacobian<One, One> jacobian(const One& r, const One& v) const {
    using std::cos;
    return {One{-2 * cos(r[0])}, One{-1 - v[0] / 2}};
  }
};
template <class T>
struct Swing {
  using One = Eigen::Matrix<T, 1, 1>;
  One operator()(const One& r) const {
    using std::sin;
    return One{-sin(r[0])};
  }
};

/// NaN in its k-th call.
struct Failing {
  std::int64_t* left;
  Eigen::Vector3d operator()(const Eigen::Vector3d& y) const {
    Eigen::Vector3d f = problems::Robertson{}(y);
    if (--*left == 0) f[1] = std::nan("");
    return f;
  }
  [[nodiscard]] Eigen::Matrix3d jacobian(const Eigen::Vector3d& y) const { return problems::Robertson{}.jacobian(y); }
};

struct DynamicHires {
  Vec operator()(const Vec& y) const { return problems::Hires{}(problems::Hires::State(y)); }
  [[nodiscard]] Eigen::MatrixXd jacobian(const Vec& y) const {
    return problems::Hires{}.jacobian(problems::Hires::State(y));
  }
};

/// The pendulum at t = 2, linearly implicit, in long double.
inline PendulumFlow<long double>::Two linear_flow(int columns, int steps) {
  using T = long double;
  const PendulumFlow<T>::Two y{T(1), T(0.5)};
  PhiStepper stepper{y, PendulumFlow<T>{}, extrapolated(backward_euler, columns)};
  return march(stepper, y, T(0), T(2), steps);
}
/// How many steps show the order of k columns, by differences to 200 steps of ten.
inline int steps_for(int k) { return k <= 2 ? 160 : 40; }

/// A step of 4 columns, plain and watched; Ψ ignores time.
template <class State>
void check_costs(const State& start, const auto& force) {
  // Rows of 2, 3, 4, 6 substeps; Ψ(t, y) serves the first of each.
  State y = start, x = start;
  PhiStepper implicit{y, force, extrapolated(backward_euler, 4)};
  REQUIRE(implicit.step(y, 0.0, 1e-3));
  CHECK(implicit.statistics().force_calls == 1 + 1 + 2 + 3 + 5);
  CHECK(implicit.statistics().jacobians == 1);
  CHECK(implicit.statistics().factorizations == 4);
  CHECK(implicit.statistics().solves == 2 + 3 + 4 + 6);
  // Watched, rows 1 and 2 compare Newton's second correction with the first: a solve each, no call.
  PhiStepper watched{x, force, extrapolated(backward_euler, 4)};
  Trace<State> trace;
  trace.resize(x);
  trace.weight.setOnes();
  trace.rtol = 1e-6;
  REQUIRE(watched.attempt(x, 0.0, 1e-3, Origin::unknown, trace, [](auto&...) { return true; }));
  CHECK(watched.statistics().force_calls == 1 + 1 + 2 + 3 + 5);
  CHECK(watched.statistics().solves == 2 + 3 + 4 + 6 + 2);
  CHECK(x == y);
}

}  // namespace extrapolated_cases
