/// @file
/// What one looks at of many particles: sums over all of them.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <limits>

#include "phistep/base/version.hpp"
#include "phistep/force/energy.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/particles/bodies/particles.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Σ m v², twice the kinetic energy of the particles' motion without their spins [energy]
template <class Scalar, int dim, class... Extra>
[[nodiscard]] Scalar twice_translational_energy(const Particles<Scalar, dim, Extra...>& y) {
  Scalar twice{0};
  for (Index i = 0; i < y.size(); ++i) twice += y.mass()[i] * y.v.col(i).squaredNorm();
  return twice;
}
/// ½ Σ m v² + ½ Σ I ω² [energy]
template <class Scalar, int dim, class... Extra>
[[nodiscard]] Scalar kinetic_energy(const Particles<Scalar, dim, Extra...>& y) {
  Scalar twice = twice_translational_energy(y);
  if constexpr (Particles<Scalar, dim, Extra...>::template has<Spin>)
    for (Index i = 0; i < y.size(); ++i) twice += y.body().inertia(i) * y.omega.col(i).squaredNorm();
  return twice / 2;
}
/// Σ m v [mass·length/time]
template <class Scalar, int dim, class... Extra>
[[nodiscard]] Eigen::Matrix<Scalar, dim, 1> momentum(const Particles<Scalar, dim, Extra...>& y) {
  return y.v * y.mass();
}
/// Σ m r / Σ m [length]
template <class Scalar, int dim, class... Extra>
[[nodiscard]] Eigen::Matrix<Scalar, dim, 1> center_of_mass(const Particles<Scalar, dim, Extra...>& y) {
  return (y.r * y.mass()) / y.mass().sum();
}
/// Σ m (r − about) × v + Σ I ω, its component along z in the plane [mass·length²/time]
template <class Scalar, int dim, class... Extra>
[[nodiscard]] auto angular_momentum(
    const Particles<Scalar, dim, Extra...>& y,
    const Eigen::Matrix<Scalar, dim, 1>& about = Eigen::Matrix<Scalar, dim, 1>::Zero()) {
  Eigen::Matrix<Scalar, dim == 3 ? 3 : 1, 1> sum;
  sum.setZero();
  for (Index i = 0; i < y.size(); ++i) {
    const Eigen::Matrix<Scalar, dim, 1> r = y.r.col(i) - about, p = y.mass()[i] * y.v.col(i);
    // The last component is that of the plane.
    if constexpr (dim == 3) sum[0] += r[1] * p[2] - r[2] * p[1], sum[1] += r[2] * p[0] - r[0] * p[2];
    sum[dim == 3 ? 2 : 0] += r[0] * p[1] - r[1] * p[0];
    if constexpr (Particles<Scalar, dim, Extra...>::template has<Spin>) sum += y.body().inertia(i) * y.omega.col(i);
  }
  return sum;
}
/// 2 E_kin/(dim (N − 1) k_B) [temperature]; 0 for fewer than two particles. The degrees of freedom are those of a constant
/// momentum, taken for zero: where all particles drift, the drift counts as heat.
template <class Scalar, int dim, class... Extra>
[[nodiscard]] Scalar temperature(const Particles<Scalar, dim, Extra...>& y, Scalar k_B = 1) {
  if (y.size() < 2) return 0;
  return twice_translational_energy(y) / (static_cast<Scalar>(dim) * static_cast<Scalar>(y.size() - 1) * k_B);
}

/// Σ r·f over the pairs of those terms that have a virial(t, y) [energy]
template <class F, class View, class Scalar>
[[nodiscard]] Scalar virial_of(F& force, Scalar t, const View& y) {
  Scalar sum{0};
  for_each_summand(force, [&](auto& term) {
    if constexpr (requires { term.virial(t, y); }) sum += static_cast<Scalar>(term.virial(t, y));
  });
  return sum;
}
/// (2 E_kin + Σ r·f)/(dim V) of particles in a periodic box [force/length^(dim−1)]; NaN where an axis is open
template <class Stepper, class Scalar, int dim, class... Extra>
[[nodiscard]] Scalar pressure(Stepper& stepper, const Particles<Scalar, dim, Extra...>& y, Scalar t = 0) {
  Scalar volume{1};
  for (int a = 0; a < dim; ++a)
    volume *= y.box().is_periodic[static_cast<std::size_t>(a)] ? y.box().length()[a]
                                                               : std::numeric_limits<Scalar>::quiet_NaN();
  const auto view = Particles<Scalar, dim, Extra...>::view(y, stepper.masses());
  return (twice_translational_energy(y) + virial_of(stepper.force_to_look_at(), t, view)) /
         (static_cast<Scalar>(dim) * volume);
}
/// Potential energy of all terms that have one [energy]
template <class Stepper, class Scalar, int dim, class... Extra>
[[nodiscard]] Scalar potential_energy(Stepper& stepper, const Particles<Scalar, dim, Extra...>& y, Scalar t = 0) {
  const auto view = Particles<Scalar, dim, Extra...>::view(y, stepper.masses());
  return potential_energy(stepper.force_to_look_at(), t, view, stepper.memory());
}

}}  // namespace phistep::PHISTEP_ABI
