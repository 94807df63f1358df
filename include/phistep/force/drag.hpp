/// @file
/// Drag proportional to the velocity.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/force/sum.hpp"

namespace phistep::inline PHISTEP_ABI {

/// The force −c v (Stokes drag: c = 6πμR).
struct LinearDrag : ForceTerm {
  double c;  ///< [force·time/length]

  static constexpr bool uses_velocity = true, uses_time = false;
  static constexpr bool is_affine = true, is_symmetric = true;
  static constexpr Structure structure = Structure::diagonal;
  template <int dim>
  static constexpr bool is_particlewise = true;

  /// @throws std::invalid_argument unless the coefficient is finite.
  explicit LinearDrag(double coefficient) : c{coefficient} {
    if (!std::isfinite(c)) throw std::invalid_argument("phistep: a drag coefficient must be finite");
  }

  void add(auto /*t*/, const auto& y, auto& out) const {
    static_assert(
        requires { out.force; }, "phistep: LinearDrag needs a motion, with velocities");
    if constexpr (requires { out.force; })
      out.force -= static_cast<typename std::remove_cvref_t<decltype(out.force)>::Scalar>(c) * y.v;
  }
  void add_jacobian(auto /*t*/, const auto& y, auto& sink) const {
    using Scalar = typename std::remove_cvref_t<decltype(y.v)>::Scalar;
    for (Eigen::Index i = 0; i < y.v.size(); ++i) sink.velocity(i, i, static_cast<Scalar>(-c));
  }
};

}  // namespace phistep::inline PHISTEP_ABI
