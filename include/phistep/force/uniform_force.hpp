/// @file
/// The same constant force on every particle.
#pragma once

#include <Eigen/Core>

#include <stdexcept>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/pattern.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The force F on each particle, whatever its mass: a force, and so not the same as Gravity. F has the d components of
/// one particle's position, or as many as the whole state.
template <class Vector = Eigen::Vector3d>
struct UniformForce : ForceTerm {
  Vector F;  ///< [force]

  static constexpr bool uses_velocity = false, uses_time = false;
  static constexpr bool is_affine = true, is_symmetric = true;
  static constexpr Structure structure = Structure::none;
  /// Not where the vector may be as long as the state.
  template <int dim>
  static constexpr bool is_particlewise =
      int{Vector::SizeAtCompileTime} > 0 && dim % int{Vector::SizeAtCompileTime} == 0;

  /// @throws std::invalid_argument unless F is finite.
  explicit UniformForce(Vector force) : F(std::move(force)) {
    if (!F.allFinite()) throw std::invalid_argument("phistep: UniformForce's F must be finite");
  }

  void add(auto /*t*/, const auto& /*y*/, auto& out) const {
    static_assert(
        requires { out.force; }, "phistep: UniformForce needs a motion, with forces");
    if constexpr (requires { out.force; }) {
      using Force = std::remove_cvref_t<decltype(out.force)>;
      check_pattern(F, out.force, "UniformForce's F");
      constexpr Eigen::Index d = Vector::SizeAtCompileTime;
      if constexpr (d > 0 && (!Force::IsRowMajor || Force::IsVectorAtCompileTime)) {  // no division in the loop
        const Eigen::Matrix<typename Force::Scalar, int{d}, 1> each =
            F.reshaped().template cast<typename Force::Scalar>();
        for (Eigen::Index i = 0; i < out.force.size(); i += d)
          for (Eigen::Index k = 0; k < d; ++k) out.force.data()[i + k] += each[k];
        return;
      }
      for (Eigen::Index i = 0; i < out.force.size(); ++i)
        out.force.data()[i] += static_cast<typename Force::Scalar>(
            F[component_of<Force>(i, out.force.rows(), out.force.cols()) % F.size()]);
    }
  }
  void add_jacobian(auto /*t*/, const auto& /*y*/, auto& /*sink*/) const {}
  /// −Σ F·r [energy]
  [[nodiscard]] auto energy(auto /*t*/, const auto& y) const requires requires { y.r; }
  {
    using Positions = std::remove_cvref_t<decltype(y.r)>;
    using Scalar = typename Positions::Scalar;
    Scalar sum{0};
    for (Eigen::Index i = 0; i < y.r.size(); ++i)
      sum -= static_cast<Scalar>(F[component_of<Positions>(i, y.r.rows(), y.r.cols()) % F.size()]) * y.r.data()[i];
    return sum;
  }
};
template <class Derived>
UniformForce(const Eigen::MatrixBase<Derived>&) -> UniformForce<typename Derived::PlainObject>;

}}  // namespace phistep::PHISTEP_ABI
