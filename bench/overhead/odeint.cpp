/// @file
/// Boost.Odeint's rows: its steppers as its manual uses them, with the force array copied into the derivative.
#include <Eigen/Core>

#if defined(__GNUC__)  // Odeint's own headers don't pass our warnings
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
#include <boost/numeric/odeint.hpp>
#include <boost/numeric/odeint/external/eigen/eigen.hpp>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "rivals.hpp"

namespace odeint = boost::numeric::odeint;
using Eigen::Index;
using Eigen::VectorXd;

namespace overhead {
namespace {

template <class State>
State make_state(Index n) {
  if constexpr (std::is_same_v<State, VectorXd>) return VectorXd(n);
  else return State(static_cast<std::size_t>(n));
}
Eigen::Map<VectorXd> as_eigen(std::vector<double>& x) { return {x.data(), static_cast<Index>(x.size())}; }
Eigen::Map<const VectorXd> as_eigen(const std::vector<double>& x) { return {x.data(), static_cast<Index>(x.size())}; }
VectorXd& as_eigen(VectorXd& x) { return x; }
const VectorXd& as_eigen(const VectorXd& x) { return x; }

/// y = (r, v)
template <class State, class Stepper>
class Euler final : public OdeintMotion {
 public:
  Euler(const VectorXd& r, const VectorXd& v, const VectorXd& f, double mass)
      : force_{f}, inverse_mass_{1 / mass}, y_{make_state<State>(2 * r.size())} {
    as_eigen(y_).head(r.size()) = r;
    as_eigen(y_).tail(r.size()) = v;
  }
  void step(double dt) override {
    const Index n = force_.size();
    stepper_.do_step(
        [this, n](const State& y, State& dydt, double /*t*/) {
          as_eigen(dydt).head(n) = as_eigen(y).tail(n);
          as_eigen(dydt).tail(n) = inverse_mass_ * force_;
        },
        y_, 0.0, dt);
  }
  VectorXd positions() const override { return as_eigen(y_).head(force_.size()); }
  VectorXd velocities() const override { return as_eigen(y_).tail(force_.size()); }

 private:
  const VectorXd& force_;
  double inverse_mass_;
  State y_;
  Stepper stepper_;
};

template <class State, class Stepper>
class Verlet final : public OdeintMotion {
 public:
  Verlet(const VectorXd& r, const VectorXd& v, const VectorXd& f, double mass)
      : force_{f}, inverse_mass_{1 / mass}, r_{make_state<State>(r.size())}, v_{make_state<State>(r.size())} {
    as_eigen(r_) = r;
    as_eigen(v_) = v;
  }
  void step(double dt) override {
    stepper_.do_step(
        [this](const State&, const State&, State& a, double /*t*/) { as_eigen(a) = inverse_mass_ * force_; },
        std::make_pair(std::ref(r_), std::ref(v_)), 0.0, dt);
  }
  VectorXd positions() const override { return as_eigen(r_); }
  VectorXd velocities() const override { return as_eigen(v_); }

 private:
  const VectorXd& force_;
  double inverse_mass_;
  State r_, v_;
  Stepper stepper_;
};

template <class State>
void lorenz(const State& y, State& dydt, double /*t*/) {
  dydt[0] = 10.0 * (y[1] - y[0]);
  dydt[1] = 28.0 * y[0] - y[1] - y[0] * y[2];
  dydt[2] = y[0] * y[1] - 8.0 / 3.0 * y[2];
}
template <class State, class Stepper>
State run_lorenz(State y, double dt, long steps) {
  Stepper stepper;
  const auto system = [](const State& x, State& dxdt, double t) { lorenz(x, dxdt, t); };
  for (long n = 0; n < steps; ++n) stepper.do_step(system, y, static_cast<double>(n) * dt, dt);
  return y;
}

using Algebra = odeint::vector_space_algebra;
template <class State>
using EigenEuler = odeint::euler<State, double, State, double, Algebra>;
using EigenVerlet = odeint::velocity_verlet<VectorXd, VectorXd, double, VectorXd, double, double, Algebra>;
using Vector = std::vector<double>;

}  // namespace

std::unique_ptr<OdeintMotion> odeint_euler_vector(const VectorXd& r, const VectorXd& v, const VectorXd& f,
                                                  double mass) {
  return std::make_unique<Euler<Vector, odeint::euler<Vector>>>(r, v, f, mass);
}
std::unique_ptr<OdeintMotion> odeint_euler_eigen(const VectorXd& r, const VectorXd& v, const VectorXd& f, double mass) {
  return std::make_unique<Euler<VectorXd, EigenEuler<VectorXd>>>(r, v, f, mass);
}
std::unique_ptr<OdeintMotion> odeint_verlet_vector(const VectorXd& r, const VectorXd& v, const VectorXd& f,
                                                   double mass) {
  return std::make_unique<Verlet<Vector, odeint::velocity_verlet<Vector>>>(r, v, f, mass);
}
std::unique_ptr<OdeintMotion> odeint_verlet_eigen(const VectorXd& r, const VectorXd& v, const VectorXd& f,
                                                  double mass) {
  return std::make_unique<Verlet<VectorXd, EigenVerlet>>(r, v, f, mass);
}

Eigen::Vector3d odeint_lorenz_array(Eigen::Vector3d y, double dt, long steps) {
  using Array = std::array<double, 3>;
  const Array end = run_lorenz<Array, odeint::euler<Array>>({y[0], y[1], y[2]}, dt, steps);
  return {end[0], end[1], end[2]};
}
Eigen::Vector3d odeint_lorenz_eigen(Eigen::Vector3d y, double dt, long steps) {
  return run_lorenz<Eigen::Vector3d, EigenEuler<Eigen::Vector3d>>(y, dt, steps);
}

}  // namespace overhead
