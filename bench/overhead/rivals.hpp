/// @file
/// The bare update by Boost.Odeint. C++17 and free of phistep: Odeint of Boost 1.74 doesn't compile as C++20.
#pragma once

#include <Eigen/Core>

#include <memory>

namespace overhead {

/// m v' = f with a force array that is given and constant, r' = v. The state is copied in once, then stepped in place.
class OdeintMotion {
 public:
  virtual ~OdeintMotion() = default;
  virtual void step(double dt) = 0;
  [[nodiscard]] virtual Eigen::VectorXd positions() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd velocities() const = 0;
};

/// Forward Euler on one vector y = (r, v), a std::vector or an Eigen vector. `f` must outlive the result.
[[nodiscard]] std::unique_ptr<OdeintMotion> odeint_euler_vector(const Eigen::VectorXd& r, const Eigen::VectorXd& v,
                                                                const Eigen::VectorXd& f, double mass);
[[nodiscard]] std::unique_ptr<OdeintMotion> odeint_euler_eigen(const Eigen::VectorXd& r, const Eigen::VectorXd& v,
                                                               const Eigen::VectorXd& f, double mass);
/// Velocity Verlet on the pair (r, v).
[[nodiscard]] std::unique_ptr<OdeintMotion> odeint_verlet_vector(const Eigen::VectorXd& r, const Eigen::VectorXd& v,
                                                                 const Eigen::VectorXd& f, double mass);
[[nodiscard]] std::unique_ptr<OdeintMotion> odeint_verlet_eigen(const Eigen::VectorXd& r, const Eigen::VectorXd& v,
                                                                const Eigen::VectorXd& f, double mass);

/// `steps` forward Euler steps of the Lorenz system (σ = 10, ρ = 28, β = 8/3).
[[nodiscard]] Eigen::Vector3d odeint_lorenz_array(Eigen::Vector3d y, double dt, long steps);
[[nodiscard]] Eigen::Vector3d odeint_lorenz_eigen(Eigen::Vector3d y, double dt, long steps);

}  // namespace overhead
