/// @file
/// A uniform gravitational acceleration.
#pragma once

#include <Eigen/Core>

#include <utility>

#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/force/sum.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The weight m g: an acceleration, and so not the same as UniformForce. For a flat vector of d-dimensional positions
/// (x₀ y₀ z₀ x₁ …) or a d×N matrix, g has d components.
template <class Vector = Eigen::Vector3d>
struct Gravity : ForceTerm {
  Vector g;  ///< [length/time²]

  static constexpr bool uses_velocity = false, uses_time = false;
  static constexpr Structure structure = Structure::none;

  explicit Gravity(Vector acceleration) : g(std::move(acceleration)) {}

  void add(auto /*t*/, const auto& y, auto& out) const {
    static_assert(requires { y.mass; }, "phistep: Gravity needs a state whose view has masses");
    using Scalar = typename std::remove_cvref_t<decltype(out.force)>::Scalar;
    y.mass.add_product([this](Eigen::Index i) { return static_cast<Scalar>(g[i % g.size()]); }, out.force);
  }
  void add_jacobian(auto /*t*/, const auto& /*y*/, auto& /*sink*/) const {}
};
template <class Derived>
Gravity(const Eigen::MatrixBase<Derived>&) -> Gravity<typename Derived::PlainObject>;

}  // namespace phistep::inline PHISTEP_ABI
