/// @file
/// Sums over all particles: energy, momentum, temperature, pressure.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <limits>
#include <type_traits>

#include "phistep/force/evaluate.hpp"
#include "phistep/force/local.hpp"
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
/// 2 E_kin/(dim (N − 1) k_B) [temperature]; 0 for fewer than two particles. The momentum is taken for 0: a drift of all counts as heat.
template <class Scalar, int dim, class... Extra>
[[nodiscard]] Scalar temperature(const Particles<Scalar, dim, Extra...>& y, Scalar k_B = 1) {
  if (y.size() < 2) return 0;
  return twice_translational_energy(y) / (static_cast<Scalar>(dim) * static_cast<Scalar>(y.size() - 1) * k_B);
}

/// A term that acts on each particle by itself.
template <class F, int dim>
inline constexpr bool acts_on_each = is_particlewise<F, dim> || requires {
  requires F::acts_on_each;
};
/// (2 E_kin + Σ r·f)/(dim V) of particles in a periodic box [force/length^(dim−1)]; NaN where an axis is open. Forces between
/// particles have a `virial(t, y)`, Σ r·f; what acts on each by itself, a field or a wall, has no part in it.
template <class Stepper, class Scalar, int dim, class... Extra>
[[nodiscard]] Scalar pressure(Stepper& stepper, const Particles<Scalar, dim, Extra...>& y, Scalar t = 0) {
  Scalar volume{1};
  for (int a = 0; a < dim; ++a)
    volume *= y.box().is_periodic[static_cast<std::size_t>(a)] ? y.box().length()[a]
                                                               : std::numeric_limits<Scalar>::quiet_NaN();
  const auto view = Particles<Scalar, dim, Extra...>::view(y, stepper.masses());
  Scalar virial{0};
  for_each_summand(stepper.force_to_look_at(), [&]<class Term>(Term& term) {
    constexpr bool has_virial = requires { term.virial(t, view); };
    static_assert(has_virial || acts_on_each<std::remove_const_t<Term>, dim>,
                  "phistep: the pressure needs the virial of this force between particles: give the term a member "
                  "virial(t, y), the sum of r.f over its pairs; or, of one that acts on each particle by itself, "
                  "static constexpr bool acts_on_each = true");
    if constexpr (has_virial) virial += static_cast<Scalar>(term.virial(t, view));
  });
  return (twice_translational_energy(y) + virial) / (static_cast<Scalar>(dim) * volume);
}
/// On a wall of the force's `Walls`, as the last step has left its springs [force]. @param wall  its number there
template <class Stepper, class Scalar, int dim, class... Extra>
[[nodiscard]] Eigen::Matrix<Scalar, dim, 1> force_on_wall(Stepper& stepper, const Particles<Scalar, dim, Extra...>& y,
                                                          std::size_t wall, Scalar t = 0) {
  const auto view = Particles<Scalar, dim, Extra...>::view(y, stepper.masses());
  Eigen::Matrix<Scalar, dim, 1> sum = Eigen::Matrix<Scalar, dim, 1>::Zero();
  auto& force = stepper.force_to_look_at();
  const auto add = [&](auto, auto& term, const auto& memory) {
    if constexpr (requires { term.force_on(wall, t, view, memory); }) sum += term.force_on(wall, t, view, memory);
  };
  if constexpr (is_sum<std::remove_cvref_t<decltype(force)>>) for_each_term(force, stepper.memory(), add);
  else add(0, force, stepper.memory());
  return sum;
}
/// Potential energy of all terms that have one [energy]
template <class Stepper, class Scalar, int dim, class... Extra>
[[nodiscard]] Scalar potential_energy(Stepper& stepper, const Particles<Scalar, dim, Extra...>& y, Scalar t = 0) {
  const auto view = Particles<Scalar, dim, Extra...>::view(y, stepper.masses());
  return potential_energy(stepper.force_to_look_at(), t, view, stepper.memory());
}

}}  // namespace phistep::PHISTEP_ABI
