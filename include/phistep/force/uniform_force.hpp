/// @file
/// The same constant force on every particle.
#pragma once

#include <Eigen/Core>

#include <type_traits>
#include <utility>

#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/force/sum.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The force F on each particle, whatever its mass: a force, and so not the same as Gravity. F has the d components of
/// one particle's position, or as many as the whole state.
template <class Vector = Eigen::Vector3d>
struct UniformForce : ForceTerm {
  Vector F;  ///< [force]

  static constexpr bool uses_velocity = false, uses_time = false;
  static constexpr Structure structure = Structure::none;

  explicit UniformForce(Vector force) : F(std::move(force)) {}

  void add(auto /*t*/, const auto& /*y*/, auto& out) const {
    using Scalar = typename std::remove_cvref_t<decltype(out.force)>::Scalar;
    for (Eigen::Index i = 0; i < out.force.size(); ++i) out.force.data()[i] += static_cast<Scalar>(F[i % F.size()]);
  }
  void add_jacobian(auto /*t*/, const auto& /*y*/, auto& /*sink*/) const {}
};
template <class Derived>
UniformForce(const Eigen::MatrixBase<Derived>&) -> UniformForce<typename Derived::PlainObject>;

}  // namespace phistep::inline PHISTEP_ABI
