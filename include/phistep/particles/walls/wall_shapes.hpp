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

#include "phistep/base/version.hpp"
#include "phistep/particles/bodies/box.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

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

/// A wall in a run's numbers.
template <class Scalar, int dim, class Shape>
class NearWall;

template <class Scalar, int dim>
class NearWall<Scalar, dim, Plane<dim>> {
  using Vector = Eigen::Matrix<Scalar, dim, 1>;

 public:
  NearWall(const Plane<dim>& wall, const Box<Scalar, dim>&)
      : point_{wall.point.template cast<Scalar>()}, normal_{wall.normal.template cast<Scalar>()} {}
  /// From the wall's nearest point to r: sets the unit normal, returns the distance (< 0 inside).
  [[nodiscard]] Scalar approach(const Vector& r, Vector& n) const {
    n = normal_;
    return n.dot(r - point_);
  }
  /// True where a body of that radius at r certainly doesn't touch the wall, found at less cost than `approach`.
  [[nodiscard]] static bool is_far(const Vector&, Scalar) { return false; }

 private:
  Vector point_, normal_;
};

/// Along periodic axes, the image whose center is nearest.
template <class Scalar, int dim>
class NearWall<Scalar, dim, SolidBox<dim>> {
  using Vector = Eigen::Matrix<Scalar, dim, 1>;

 public:
  NearWall(const SolidBox<dim>& wall, const Box<Scalar, dim>& box)
      : center_{wall.center.template cast<Scalar>()},
        half_{wall.half.template cast<Scalar>()},
        axes_{wall.axes.template cast<Scalar>()},
        reach_{half_.norm()},
        box_{box},
        has_images_{!box.is_open()} {}

  [[nodiscard]] Scalar approach(const Vector& r, Vector& n) const {
    const Vector q = axes_.transpose() * from_center(r);
    const Vector out = q - q.cwiseMax(-half_).cwiseMin(half_);
    const Scalar distance = out.norm();
    if (distance > 0) {
      n = axes_ * (out / distance);
      return distance;
    }
    int face = 0;  // the nearest one: out by the shortest way
    for (int a = 1; a < dim; ++a)
      if (half_[a] - std::abs(q[a]) < half_[face] - std::abs(q[face])) face = a;
    n = q[face] < 0 ? Vector(-axes_.col(face)) : Vector(axes_.col(face));
    return std::abs(q[face]) - half_[face];
  }
  [[nodiscard]] bool is_far(const Vector& r, Scalar radius) const {
    const Scalar least = Scalar(1.0001L) * (reach_ + radius);
    return from_center(r).squaredNorm() > least * least;
  }

 private:
  [[nodiscard]] Vector from_center(const Vector& r) const {
    const Vector d = r - center_;
    return has_images_ ? box_.nearest(d) : d;
  }

  Vector center_, half_;
  Eigen::Matrix<Scalar, dim, dim> axes_;
  Scalar reach_;
  Box<Scalar, dim> box_;
  bool has_images_;
};

}}  // namespace phistep::PHISTEP_ABI
