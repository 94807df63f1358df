#pragma once

// What the restarts of first-order problems share, quick and full: a chain with Jacobians of all kinds.

#include <phistep/phistep.hpp>

#include <Eigen/SparseCore>

#include <algorithm>
#include <limits>
#include <utility>

#include "contract/restart.hpp"
#include "contract/states.hpp"
#include "support/shared_force.hpp"

namespace restart_cases {

using namespace phistep;
using restart::check;
using restart::loosely;
using restart::Steps;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

inline constexpr Eigen::Index n = 7;

/// y_i' = −3 y_i + 1.2 y_{i−1} + y_{i+1} − 0.2 y_i³, in any scalar.
struct Chain {
  template <class V>
  auto operator()(const V& y) const {
    std::remove_cvref_t<decltype(y.eval())> rate(y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      rate[i] = -3.0 * y[i] - 0.2 * y[i] * y[i] * y[i];
      if (i > 0) rate[i] += 1.2 * y[i - 1];
      if (i + 1 < y.size()) rate[i] += y[i + 1];
    }
    return rate;
  }
};
inline Mat tangent(const Vec& y, double below = 1.2) {
  Mat J = Mat::Zero(y.size(), y.size());
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    J(i, i) = -3 - 0.6 * y[i] * y[i];
    if (i > 0) J(i, i - 1) = below;
    if (i + 1 < y.size()) J(i, i + 1) = 1;
  }
  return J;
}
inline const shared_force::OfState<Vec> chain = [](const Vec& y) -> Vec { return Chain{}(y); };
struct WithJacobian {
  Vec operator()(const Vec& y) const { return Chain{}(y); }
  [[nodiscard]] Mat jacobian(const Vec& y) const { return tangent(y); }
};
struct WithSparseJacobian {
  Vec operator()(const Vec& y) const { return Chain{}(y); }
  [[nodiscard]] Sparse jacobian(const Vec& y) const { return tangent(y).sparseView(); }
};
/// Symmetric; driven apart by `push` > 0, so that W loses its definiteness.
struct Even {
  double push = 0;
  Vec operator()(const Vec& y) const {
    Vec rate = Chain{}(y) + push * y;
    for (Eigen::Index i = 1; i < y.size(); ++i) rate[i] -= 0.2 * y[i - 1];
    return rate;
  }
  [[nodiscard]] Sparse jacobian(const Vec& y) const {
    return (tangent(y, 1.0) + push * Mat::Identity(y.size(), y.size())).sparseView();
  }
};
/// With entries that come and go: the pattern changes during the run.
struct Thinning : WithSparseJacobian {
  [[nodiscard]] Sparse jacobian(const Vec& y) const {
    Mat J = tangent(y);
    if (y[0] < 0.6) J(0, 1) = 0;
    return J.sparseView();
  }
};

inline Vec start_of(Eigen::Index size) { return Vec::LinSpaced(size, 0, 4).array().cos(); }
inline Vec start() { return start_of(n); }

/// A tolerance, so that factors serve steps of other lengths too, with scaled corrections.
template <class Solver = void>
auto tolerant() {
  return newton<Solver>({.rtol = 1e-4, .atol = 1e-6});
}
inline const Steps even{0.05}, uneven{0.05, false};

/// A stepper maker.
template <class F, class... More>
auto steps(F f, More... more) {
  return [=](const auto& y) { return PhiStepper{y, f, more...}; };
}

/// Runs in another scalar.
template <class T>
void check_scalar(double rtol) {
  using V = Eigen::Matrix<T, Eigen::Dynamic, 1>;
  const auto force = [](const V& y) -> V { return -T(3) * y - (y.array().cube() / T(7)).matrix(); };
  const auto from = [] { return V(start().cast<T>() / T(3)); };
  Steps loose = uneven, tight = uneven;
  loose.near = 30 * rtol;  // y decays to a few atol
  tight.near = std::max(1e3 * static_cast<double>(std::numeric_limits<T>::epsilon()), 1e-12);
  check(loose, from, steps(force, phi(0.7), newton({.rtol = rtol, .atol = rtol / 100})));
  check(tight, from, steps(force, tr_bdf2));
  using Fixed = Eigen::Matrix<T, 3, 1>;
  const auto fixed = [](const Fixed& y) -> Fixed { return -T(3) * y - (y.array().cube() / T(7)).matrix(); };
  check(
      tight,
      [] {
        return Fixed{T(1) / T(3), T(-2) / T(7), T(1)};
      },
      steps(fixed, tr_bdf2));
}

void check_moved(const auto& make) {
  Vec y = start(), moved_y = start();
  auto stepper = make(y);
  auto first = make(moved_y);
  for (int k = 0; k < 5; ++k) {
    REQUIRE(stepper.step(y, k * 0.05, 0.05));
    REQUIRE(first.step(moved_y, k * 0.05, 0.05));
  }
  auto second = std::move(first);
  for (int k = 5; k < 10; ++k) {
    REQUIRE(stepper.step(y, k * 0.05, 0.05));
    REQUIRE(second.step(moved_y, k * 0.05, 0.05));
  }
  CHECK(states::same_bits(y, moved_y));
  CHECK(stepper.statistics() == second.statistics());
}

}  // namespace restart_cases
