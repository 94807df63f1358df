/// @file
/// The shapes of walls, and where they are nearest to a point.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "phistep/core/version.hpp"

namespace phistep::inline PHISTEP_ABI {

/// A half space.
template <int dim = 3>
struct Plane {
  using Vector = Eigen::Matrix<double, dim, 1>;
  Vector point;                      ///< [length] anywhere on it
  Vector normal;                     ///< towards the bodies, of any length
  Vector velocity = Vector::Zero();  ///< [length/time] of its surface, as of a conveyor: the plane stays
  int type = 0;                      ///< in the table of materials
};
/// A solid box in any orientation: a slab, a step, a chute's side. Bodies are outside.
template <int dim = 3>
struct SolidBox {
  using Vector = Eigen::Matrix<double, dim, 1>;
  using Axes = Eigen::Matrix<double, dim, dim>;
  Vector center;                     ///< [length]
  Vector half;                       ///< [length] half its edges
  Axes axes = Axes::Identity();      ///< columns: the directions of its edges, orthonormal
  Vector velocity = Vector::Zero();  ///< [length/time] of its surface
  int type = 0;                      ///< in the table of materials
};
template <int dim = 3>
using Wall = std::variant<Plane<dim>, SolidBox<dim>>;

/// The faces of a box that bodies are inside of.
template <class Lower, class Upper = Lower, int dim = Lower::SizeAtCompileTime>
[[nodiscard]] std::vector<Wall<dim>> inside_box(const Lower& lower, const Upper& upper, int type = 0) {
  using Vector = Eigen::Matrix<double, dim, 1>;
  std::vector<Wall<dim>> walls;
  for (int a = 0; a < dim; ++a) {
    const Vector e = Vector::Unit(a);
    walls.push_back(Plane<dim>{lower, e, Vector::Zero(), type});
    walls.push_back(Plane<dim>{upper, -e, Vector::Zero(), type});
  }
  return walls;
}

[[noreturn]] inline void refuse_wall(std::size_t wall, const char* what) {
  throw std::invalid_argument("phistep: wall " + std::to_string(wall) + what);
}
/// @throws std::invalid_argument where wall number w has no normal or no thickness; makes a normal of length 1
template <int dim>
void check_wall(Plane<dim>& wall, std::size_t w) {
  const double length = wall.normal.norm();
  if (!(length > 0) || !std::isfinite(length) || !wall.point.allFinite() || !wall.velocity.allFinite())
    refuse_wall(w, " needs a finite point and velocity, and a normal");
  wall.normal /= length;
}
template <int dim>
void check_wall(const SolidBox<dim>& wall, std::size_t w) {
  if (!wall.center.allFinite() || !wall.half.allFinite() || !(wall.half.minCoeff() > 0) || !wall.velocity.allFinite())
    refuse_wall(w, " needs a finite center and velocity, and edges > 0");
  if (!((wall.axes.transpose() * wall.axes).isIdentity(1e-9))) refuse_wall(w, " needs orthonormal axes");
}

/// From the wall's nearest point to r: sets the unit normal, returns the distance (< 0 inside).
template <class Scalar, int dim>
[[nodiscard]] inline Scalar approach(const Plane<dim>& wall, const Eigen::Matrix<Scalar, dim, 1>& r,
                                     Eigen::Matrix<Scalar, dim, 1>& n) {
  n = wall.normal.template cast<Scalar>();
  return n.dot(r - wall.point.template cast<Scalar>());
}
template <class Scalar, int dim>
[[nodiscard]] inline Scalar approach(const SolidBox<dim>& wall, const Eigen::Matrix<Scalar, dim, 1>& r,
                                     Eigen::Matrix<Scalar, dim, 1>& n) {
  using Vector = Eigen::Matrix<Scalar, dim, 1>;
  const auto axes = wall.axes.template cast<Scalar>().eval();
  const Vector q = axes.transpose() * (r - wall.center.template cast<Scalar>()),
               half = wall.half.template cast<Scalar>();
  const Vector out = q - q.cwiseMax(-half).cwiseMin(half);
  const Scalar distance = out.norm();
  if (distance > 0) {
    n = axes * (out / distance);
    return distance;
  }
  int face = 0;  // the nearest one: out by the shortest way
  for (int a = 1; a < dim; ++a)
    if (half[a] - std::abs(q[a]) < half[face] - std::abs(q[face])) face = a;
  n = q[face] < 0 ? Vector(-axes.col(face)) : Vector(axes.col(face));
  return std::abs(q[face]) - half[face];
}

}  // namespace phistep::inline PHISTEP_ABI
