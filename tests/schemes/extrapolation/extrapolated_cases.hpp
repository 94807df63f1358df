#pragma once

// What the quick and the full half of schemes/extrapolation/extrapolated share.
#include <phistep/phistep.hpp>
#include <phistep/schemes/extrapolation/extrapolated.hpp>

#include <cmath>
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

}  // namespace extrapolated_cases
