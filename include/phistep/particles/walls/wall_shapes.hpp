/// @file
/// The shapes of walls, where they are nearest to a point, and which bodies touch them.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "phistep/base/machine/shares.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/particles/contacts/contact_pairs.hpp"
#include "phistep/particles/contacts/spring_table.hpp"

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

/// Which bodies touch which walls, and where. A workspace, its buffers serve again.
template <class Scalar, int dim>
class TouchingWalls {
 public:
  std::vector<ContactPoint<Scalar>> points;  ///< of each contact, and as many more as fill its pack
  std::vector<std::int32_t> from;            ///< where its springs stand in the table before
  std::int64_t count = 0;                    ///< of contacts

  /// Fills the table with the contacts' places, and makes room for their springs.
  /// @param active  of these bodies; null: of all
  void find(const std::vector<Wall<dim>>& walls, const auto& y, const ActiveSet* active, const auto& before,
            auto& table, bool with_roll) {
    points.clear(), from.clear(), table.place.clear();
    auto springs_of = spring_finder(before.place, std::int64_t{0});
    for (std::size_t k = 0; k < walls.size(); ++k)
      std::visit(
          [&](const auto& wall) {
            const Vector surface = wall.velocity.template cast<Scalar>();
            Vector n;
            for_each_touching(wall, y, active, [&](Eigen::Index i) {
              const Scalar radius = y.body.radius[i], distance = approach(wall, y, y.r.col(i), radius, n);
              if (std::holds_alternative<SolidBox<dim>>(walls[k]) && is_hidden(walls, k, y, i, n, distance)) return;
              table.place.push_back(WallBodies::place(static_cast<std::int64_t>(k), static_cast<std::int32_t>(i)));
              from.push_back(springs_of(table.place.back()));
              ContactPoint<Scalar>& at = points.emplace_back();
              at = {triple(n), radius - distance,          distance / radius, triple(y.v.col(i) - surface),
                    {},        Scalar{1} / y.body.mass[i], Scalar{1} / radius};
              if constexpr (HasSpin<decltype(y)>) at.turning = triple(y.omega.col(i));
            });
          },
          walls[k]);
    const std::size_t found = table.place.size();
    count = static_cast<std::int64_t>(found);
    table.resize(found, with_roll);
    // A whole pack more, with numbers that do no harm.
    constexpr std::size_t width = native_width<Scalar>;
    constexpr Triple<Scalar> ones{1, 1, 1};
    points.resize(found + width, {ones, 1, 1, ones, ones, 1, 1, ones});
    from.resize(found + width, static_cast<std::int32_t>(before.size()));
  }

 private:
  using Vector = Eigen::Matrix<Scalar, dim, 1>;
  /// From a wall's nearest point to r: sets the unit normal, returns the distance (< 0 inside). Infinity, at less cost, where it is far
  /// beyond `reach`.
  [[nodiscard]] static Scalar approach(const Plane<dim>& wall, const auto& /*y*/, const Vector& r, Scalar /*reach*/,
                                       Vector& n) {
    n = wall.normal.template cast<Scalar>();
    return n.dot(r - wall.point.template cast<Scalar>());
  }
  /// Along periodic axes, from the image whose center is nearest.
  [[nodiscard]] static Scalar approach(const SolidBox<dim>& wall, const auto& y, const Vector& r, Scalar reach,
                                       Vector& n) {
    const Vector half = wall.half.template cast<Scalar>(),
                 from_center = y.body.box.nearest(r - wall.center.template cast<Scalar>());
    const Scalar least = Scalar(1.0001L) * (half.norm() + reach);
    if (from_center.squaredNorm() > least * least) return std::numeric_limits<Scalar>::infinity();
    const Eigen::Matrix<Scalar, dim, dim> axes = wall.axes.template cast<Scalar>();
    const Vector q = axes.transpose() * from_center, out = q - q.cwiseMax(-half).cwiseMin(half);
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
  /// Whether the point where body i touches box k lies in another wall, which is as near: edges of boxes that meet flush don't act.
  [[nodiscard]] static bool is_hidden(const std::vector<Wall<dim>>& walls, std::size_t k, const auto& y, Eigen::Index i,
                                      const Vector& n, Scalar distance) {
    const Vector r = y.r.col(i), q = r - distance * n;
    // Boxes are flush up to rounding of their places, and of what is far smaller than a body.
    const Scalar rounding = 16 * std::numeric_limits<Scalar>::epsilon() * std::max(r.cwiseAbs().maxCoeff(), distance);
    const Scalar seam = Scalar(1e-6L) * y.body.radius[i] + rounding;
    const auto hides = [&](std::size_t other, const auto& wall) {
      Vector unused;
      if (approach(wall, y, q, seam, unused) > seam) return false;
      const Scalar nearer = distance - approach(wall, y, r, std::numeric_limits<Scalar>::infinity(), unused);
      return nearer > rounding || (nearer >= -rounding && other < k);
    };
    for (std::size_t other = 0; distance > 0 && other < walls.size(); ++other)
      if (other != k && std::visit([&](const auto& wall) { return hides(other, wall); }, walls[other])) return true;
    return false;
  }
  /// The three numbers of a vector, or of a spin in the plane.
  [[nodiscard]] static Triple<Scalar> triple(const auto& x) {
    if constexpr (std::remove_cvref_t<decltype(x)>::RowsAtCompileTime == 1) return {0, 0, x[0]};
    else return {x[0], x[1], dim == 3 ? x[dim - 1] : Scalar{0}};
  }
  /// f(i), ascending. Threads share the search.
  void for_each_touching(const auto& wall, const auto& y, const ActiveSet* active, auto&& f) {
    const std::size_t bodies = active ? active->list().size() : static_cast<std::size_t>(y.r.cols());
    touching_.resize(bodies);
    found_.assign(thread_count(), {});
    for_each_share(bodies, 1, shared_from / 16, [&](const Share& own) {
      Vector n;
      std::size_t end = own.begin;
      for (std::size_t b = own.begin; b < own.end; ++b) {
        const std::int32_t i = active ? active->list()[b] : static_cast<std::int32_t>(b);
        const Vector r = y.r.col(i);
        // A position that is NaN touches, so that its force becomes NaN.
        if (!(approach(wall, y, r, y.body.radius[i], n) >= y.body.radius[i]) && !y.body.is_still(i))
          touching_[end++] = i;
      }
      found_[own.number] = {own.begin, end};
    });
    for (const auto& [begin, end] : found_)
      for (std::size_t b = begin; b < end; ++b) f(Eigen::Index{touching_[b]});
  }
  std::vector<std::int32_t> touching_;  // what each thread has found, from where its share begins
  std::vector<std::array<std::size_t, 2>> found_;
};

}}  // namespace phistep::PHISTEP_ABI
