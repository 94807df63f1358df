/// @file
/// Jacobians by forward automatic differentiation with Eigen's AutoDiff module, eight directions at a time.
#pragma once

#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

#include <algorithm>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/motion.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A force with a Jacobian by automatic differentiation. The force must be generic in its scalar:
///
///     auto force = autodiff([](const auto& y) {
///       std::remove_cvref_t<decltype(y)> rate(y.size());     // not VectorXd: the scalar differs
///       …
///       return rate;
///     });
///
/// Beware of what has no derivative: `r.norm()` at r = 0 gives NaN, which is reported as a non-finite Jacobian.
template <class F>
class AutoDiff : public ForceTerm {
 public:
  explicit AutoDiff(F f) : f_(std::move(f)) {}

  template <class... Arguments>
    requires std::is_invocable_v<F&, Arguments...>
  decltype(auto) operator()(Arguments&&... arguments) { return f_(std::forward<Arguments>(arguments)...); }

  /// ∂Ψ/∂y or, for a motion without velocities, ∂Ψ/∂r: n×n. @param time  where the force takes it
  template <class Vector, class... Time>
  auto jacobian(const Vector& y, const Time&... time) {
    return derivative(y, [&](const auto& moved) { return f_(moved, time...); });
  }
  /// K = ∂Ψ/∂r and C = ∂Ψ/∂v.
  template <class Vector, class... Time>
  auto jacobian(const Vector& r, const Vector& v, const Time&... time) {
    const DualVector<Vector> still_r = r.template cast<Dual<Vector>>(), still_v = v.template cast<Dual<Vector>>();
    return MotionJacobian<Square<Vector>>{derivative(r, [&](const auto& x) { return f_(x, still_v, time...); }),
                                          derivative(v, [&](const auto& u) { return f_(still_r, u, time...); })};
  }

  /// out += ∂Ψ/∂y·x by one evaluation with one direction: for solvers that need no matrix.
  template <class View, class Rate>
    requires(call_arity<F, View>() > 0)
  void apply_jacobian(auto t, const View& y, const View& x, Rate& out) {
    constexpr int arity = call_arity<F, View>();
    auto& block = std::get<0>(Rate::blocks(out));
    const auto add = [&block](const auto& result) {
      for (Eigen::Index i = 0; i < block.size(); ++i) block.data()[i] += result.data()[i].derivatives()[0];
    };
    if constexpr (MotionLike<View>) {
      const auto r = along(y.r, x.r), v = along(y.v, x.v);
      add(call_with<arity>(f_, MotionView<std::remove_const_t<decltype(r)>, decltype(y.mass)>{r, v, y.mass}, t));
    } else {
      const auto moved = along(y.y, x.y);
      add(call_with<arity>(f_, FirstOrderView<std::remove_const_t<decltype(moved)>, decltype(y.mass)>{moved, y.mass},
                           t));
    }
  }

 private:
  static constexpr int chunk = 8;
  template <class Vector, int width = chunk>
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<typename Vector::Scalar, width, 1>>;
  template <class Vector, int width = chunk>
  using DualVector =
      Eigen::Matrix<Dual<Vector, width>, Vector::RowsAtCompileTime, Vector::ColsAtCompileTime, Vector::Options>;

  /// y + x dε
  template <class Vector>
  static auto along(const Vector& y, const Vector& x) {
    DualVector<Vector, 1> moved = y.template cast<Dual<Vector, 1>>();
    for (Eigen::Index i = 0; i < y.size(); ++i) moved.data()[i].derivatives()[0] = x.data()[i];
    return moved;
  }

  template <class Vector>
  using Square = Eigen::Matrix<typename Vector::Scalar, Vector::SizeAtCompileTime, Vector::SizeAtCompileTime>;

  template <class Vector, class Function>
  static Square<Vector> derivative(const Vector& y, Function&& function) {
    using Derivatives = typename Dual<Vector>::DerType;
    const Eigen::Index n = y.size();
    Square<Vector> J(n, n);
    DualVector<Vector> moved = y.template cast<Dual<Vector>>();
    for (Eigen::Index first = 0; first < n; first += chunk) {
      const Eigen::Index width = std::min<Eigen::Index>(chunk, n - first);
      for (Eigen::Index k = 0; k < width; ++k) moved.data()[first + k].derivatives() = Derivatives::Unit(k);
      const auto result = function(moved);
      static_assert(std::is_same_v<typename std::remove_cvref_t<decltype(result)>::Scalar, Dual<Vector>>,
                    "phistep: autodiff(f) needs a force that returns a vector of its argument's scalar");
      for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index k = 0; k < width; ++k) J(i, first + k) = result.data()[i].derivatives()[k];
      for (Eigen::Index k = 0; k < width; ++k) moved.data()[first + k].derivatives().setZero();
    }
    return J;
  }

  F f_;
};

/// Asks for the force's Jacobian by automatic differentiation.
template <class F>
[[nodiscard]] AutoDiff<F> autodiff(F force) {
  return AutoDiff<F>{std::move(force)};
}

}}  // namespace phistep::PHISTEP_ABI
