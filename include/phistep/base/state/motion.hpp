/// @file
/// Positions and velocities: the state of m v' = Ψ(r, v, t), r' = v.
#pragma once

#include <Eigen/Core>

#include <array>
#include <tuple>

#include "phistep/base/state/blocks.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What a force sees of a motion.
template <class Vector, class Mass>
struct MotionView {
  const Vector& r;   ///< positions [length]
  const Vector& v;   ///< velocities [length/time]
  const Mass& mass;  ///< m in m v' = Ψ
};

/// Positions and velocities, the state of m r'' = Ψ(r, v, t). `Vector` is any Eigen vector or matrix (3×N: one column a particle), owning or a Map of the
/// user's own arrays, which are then stepped in place.
template <class Vector>
struct Motion {
  Vector r;  ///< positions [length]
  Vector v;  ///< velocities [length/time], shaped like r

  using Plain = Motion<typename Vector::PlainObject>;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v); }
  static constexpr std::array block_names{"r", "v"};
  struct Rate {
    typename Vector::PlainObject force;  ///< Ψ [force], shaped like v
    static auto blocks(auto& psi) { return std::tie(psi.force); }
  };
  template <class Masses>
  static auto view(const Plain& y, const Masses& masses) {
    return MotionView<typename Vector::PlainObject, std::tuple_element_t<0, Masses>>{y.r, y.v, std::get<0>(masses)};
  }
};

/// No motion.
template <class Vector>
  requires(!requires { typename Vector::PlainObject; })
struct Motion<Vector> {
  static_assert(
      !sizeof(Vector),
      "phistep: Motion{r, v} takes Eigen vectors or matrices, or Maps of your arrays (Eigen::Map<Eigen::VectorXd> "
      "r{x.data(), n}); one number is an Eigen::Vector<double, 1>");
  Motion(const auto&... /*any*/) {}
};

/// Maps and Refs stay what they are; an expression such as `Vec::Zero()` becomes the vector it stands for.
template <class Position, class Velocity>
Motion(const Position&, const Velocity&) -> Motion<Position>;
template <class Expression, class Velocity>
  requires(!EigenDense<Expression> && requires { typename Expression::PlainObject; })
Motion(const Expression&, const Velocity&)
->Motion<typename Expression::PlainObject>;

}}  // namespace phistep::PHISTEP_ABI
