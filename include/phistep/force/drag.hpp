/// @file
/// Drag proportional to the velocity, and to its square.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "phistep/base/facts/structure.hpp"
#include "phistep/force/local.hpp"
#include "phistep/force/sum.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

/// The force −c |v| v on each particle (c = ½ ρ C_d A: a sphere of cross-section A in a fast flow).
///
///     QuadraticDrag{c}        // in space
///     QuadraticDrag<2>{c}     // in the plane
template <int dim = 3>
struct QuadraticDrag : ForceTerm {
  double c;  ///< [force·time²/length²]

  static constexpr bool uses_velocity = true, uses_time = false, is_symmetric = true;
  static constexpr Structure structure = Structure::local;
  static constexpr int block = dim;
  template <int coordinates>
  static constexpr bool is_particlewise = coordinates == dim;

  /// @throws std::invalid_argument unless the coefficient is finite.
  explicit QuadraticDrag(double coefficient) : c{coefficient} {
    if (!std::isfinite(c)) throw std::invalid_argument("phistep: a drag coefficient must be finite");
  }

  /// @throws std::invalid_argument where the state isn't made of particles of dim coordinates.
  void add(auto /*t*/, const auto& y, auto& out) const {
    for_each_velocity(y, [&](Eigen::Index at, const auto& v) {
      using Vector = typename std::remove_cvref_t<decltype(v)>::PlainObject;
      Eigen::Map<Vector>(out.force.data() + at) -= static_cast<typename Vector::Scalar>(c) * v.norm() * v;
    });
  }
  /// ∂F/∂v = −c (|v| I + v vᵀ/|v|), 0 at rest
  void add_jacobian(auto /*t*/, const auto& y, auto& sink) const {
    for_each_velocity(y, [&](Eigen::Index at, const auto& v) {
      using Scalar = typename std::remove_cvref_t<decltype(v)>::Scalar;
      const Scalar speed = v.norm(), inverse = speed > 0 ? 1 / speed : Scalar{0};
      for (int j = 0; j < dim; ++j)
        for (int i = 0; i < dim; ++i)
          sink.velocity(at + i, at + j,
                        static_cast<Scalar>(-c) * ((i == j ? speed : Scalar{0}) + v[i] * v[j] * inverse));
    });
  }

 private:
  static void for_each_velocity(const auto& y, auto&& f) {
    using Block = std::remove_cvref_t<decltype(y.v)>;
    check_particles<dim>(y.v, "QuadraticDrag");
    for (Eigen::Index at = 0; at < y.v.size(); at += dim)
      f(at, Eigen::Map<const Eigen::Matrix<typename Block::Scalar, dim, 1>>(y.v.data() + at));
  }
};

}}  // namespace phistep::PHISTEP_ABI
