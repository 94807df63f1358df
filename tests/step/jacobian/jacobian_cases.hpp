// What jacobian.test.cpp and jacobian.full.cpp share.
#pragma once

#include <phistep/step/jacobian/analytic.hpp>
#include <phistep/step/jacobian/autodiff.hpp>
#include <phistep/step/jacobian/differences.hpp>
#include <phistep/study/checks/check_jacobian.hpp>

#include <cmath>
#include <vector>

#include "contract/states.hpp"
#include "support/catch.hpp"

using namespace phistep;
using Vec = Eigen::VectorXd;
using Mat = Eigen::MatrixXd;

namespace jacobian_cases {

/// ∂Ψ/∂y of a force whose entries the test sets.
struct Given {
  Mat J;
  Vec operator()(const Vec& y) const { return Mat(true_J()) * y; }
  static Mat true_J() { return (Mat(3, 3) << 1, 2, 0, -4, 5, 6, 0, 0, 1e-3).finished(); }
  Mat jacobian(const Vec&) const { return J; }
};
struct Timed {
  auto operator()(const auto& y, double t) const {
    return typename std::remove_cvref_t<decltype(y)>::PlainObject(t * y);
  }
  Mat jacobian(const auto& y, double t) const { return t * Mat::Identity(y.size(), y.size()); }
};

inline auto damped_by_autodiff() {
  return autodiff([](const auto& r, const auto& v, double t) {
    std::remove_cvref_t<decltype(r)> f = r;
    for (Eigen::Index i = 0; i < r.size(); ++i) f[i] = -r[i] * r[i] * t - 0.5 * v[i];
    return f;
  });
}

}  // namespace jacobian_cases
