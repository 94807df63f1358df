/// @file
/// A problem as solvers of y' = f(t, y) see it: the very force that phistep steps, on bare arrays, y = (r, v) for motions.
#pragma once

#include <Eigen/Core>
#include <phistep/phistep.hpp>

#include <type_traits>
#include <utility>

namespace work_precision {

/// Force: with static `rate` and `entries`, of y or of t and y, or static `acceleration`, or a term (`add`, `add_jacobian`); S: the state that
/// phistep steps; masses: one a component of r.
template <class S, class Force>
class FirstOrder {
  static constexpr bool drifts = !phistep::EigenDense<S>;
  template <class V>
  using Const = Eigen::Map<const V>;

 public:
  FirstOrder(const S& start, Force force, const Eigen::VectorXd& masses = {})
      : start_{start}, force_{std::move(force)}, inverse_masses_{masses.cwiseInverse()} {
    if constexpr (drifts)
      if (masses.size() == 0) inverse_masses_ = Eigen::VectorXd::Ones(start.r.size());
  }

  [[nodiscard]] Eigen::VectorXd start() const {
    if constexpr (drifts) {
      Eigen::VectorXd y(2 * start_.r.size());
      y << start_.r, start_.v;
      return y;
    } else {
      return start_;
    }
  }

  /// out = f(t, y)
  void rate(double t, const double* y, double* out) const {
    if constexpr (requires { Force::rate(y, out); }) {
      Force::rate(y, out);
    } else if constexpr (requires { Force::rate(t, y, out); }) {
      Force::rate(t, y, out);
    } else if constexpr (drifts) {
      using V = std::remove_cvref_t<decltype(start_.r)>;
      const auto n = start_.r.size();
      const Const<V> r(y, n), v(y + n, n);
      Eigen::Map<V>(out, n) = v;
      if constexpr (requires { Force::acceleration(y, out); }) {
        Force::acceleration(y, out + n);
      } else {
        Eigen::Map<V> force(out + n, n);
        force.setZero();
        Forces<V> to{force};
        force_.add(t, Moving<V>{r, v}, to);
        force.array() *= inverse_masses_.array();
      }
    } else {
      const Const<S> now(y, start_.size());
      Eigen::Map<S> to(out, start_.size());
      to.setZero();
      Rates rates{to};
      force_.add(t, Still{now}, rates);
    }
  }

  /// Calls put(i, j, x) for parts x of ∂f_i/∂y_j, always in the same order; nothing where there is an acceleration only.
  void jacobian([[maybe_unused]] double t, const double* y, auto&& put) const {
    if constexpr (requires { Force::entries(y, put); }) {
      Force::entries(y, put);
    } else if constexpr (requires { Force::entries(t, y, put); }) {
      Force::entries(t, y, put);
    } else if constexpr (requires(double* out) { Force::acceleration(y, out); }) {
      return;
    } else if constexpr (drifts) {
      using V = std::remove_cvref_t<decltype(start_.r)>;
      const auto n = start_.r.size();
      const Const<V> r(y, n), v(y + n, n);
      for (Eigen::Index i = 0; i < n; ++i) put(i, n + i, 1.0);
      const auto position = [&](auto i, auto j, double x) { put(n + i, j, inverse_masses_[i] * x); };
      const auto velocity = [&](auto i, auto j, double x) { put(n + i, n + j, inverse_masses_[i] * x); };
      MotionSink<decltype(position), decltype(velocity)> sink{position, velocity};
      force_.add_jacobian(t, Moving<V>{r, v}, sink);
    } else {
      const Const<S> now(y, start_.size());
      Sink<std::remove_reference_t<decltype(put)>> sink{put};
      force_.add_jacobian(t, Still{now}, sink);
    }
  }

 private:
  struct Still {
    const Const<S>& y;
  };
  struct Rates {
    Eigen::Map<S>& rate;
  };
  template <class V>
  struct Moving {
    const Const<V>&r, &v;
  };
  template <class V>
  struct Forces {
    Eigen::Map<V>& force;
  };
  template <class Put>
  struct Sink {
    Put& put;
    void rate(Eigen::Index i, Eigen::Index j, double x) { put(i, j, x); }
  };
  template <class Position, class Velocity>
  struct MotionSink {
    const Position& to_position;
    const Velocity& to_velocity;
    void position(Eigen::Index i, Eigen::Index j, double x) { to_position(i, j, x); }
    void velocity(Eigen::Index i, Eigen::Index j, double x) { to_velocity(i, j, x); }
  };

  S start_;
  Force force_;
  Eigen::VectorXd inverse_masses_;
};

}  // namespace work_precision
