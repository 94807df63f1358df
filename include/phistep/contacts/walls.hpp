/// @file
/// Walls: planes and solid boxes that don't move, with the contact laws of bodies (contact_law.hpp).
///
///     Walls walls{Hooke{.stiffness = 1e5, .friction = 0.5}, Plane<3>{.point = …, .normal = …}, SolidBox<3>{…}};
///
/// A wall is a body of infinite mass and radius: m* = m, R* = R. It pushes along the normal of the nearest of its points,
/// there where friction acts, too.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "phistep/contacts/contact_kernel.hpp"
#include "phistep/contacts/contact_law.hpp"
#include "phistep/contacts/contact_memory.hpp"
#include "phistep/contacts/contact_pairs.hpp"
#include "phistep/contacts/contact_tangent.hpp"
#include "phistep/core/scratch.hpp"
#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/simd/pack.hpp"
#include "phistep/simd/pack_math.hpp"
#include "phistep/simd/update.hpp"

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
/// A solid box, turned as one likes: a slab, a step, a chute's side. Bodies are outside.
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
template <class Vector, int dim = Vector::SizeAtCompileTime>
[[nodiscard]] std::vector<Wall<dim>> inside_box(const Vector& lower, const Vector& upper, int type = 0) {
  std::vector<Wall<dim>> walls;
  for (int a = 0; a < dim; ++a) {
    const Vector e = Vector::Unit(a);
    walls.push_back(Plane<dim>{lower, e, Vector::Zero(), type});
    walls.push_back(Plane<dim>{upper, -e, Vector::Zero(), type});
  }
  return walls;
}

/// The bodies that walls remember, in the user's order.
template <class Scalar>
struct WallBodies {
  ContactBodies<Scalar> bodies;
  void archive(auto& ar) { ar("bodies", bodies); }
};
/// The springs of those that touch a wall, sorted by wall and body.
template <class Scalar>
struct WallSprings {
  std::vector<std::int32_t> wall, body;
  std::vector<Scalar> slip, roll;  ///< 3 numbers a contact; roll may be empty

  [[nodiscard]] std::size_t size() const { return wall.size(); }
  void clear() { wall.clear(), body.clear(), slip.clear(), roll.clear(); }
  [[nodiscard]] bool fits(const WallBodies<Scalar>& of) const {
    return std::all_of(body.begin(), body.end(),
                       [&](std::int32_t i) { return i >= 0 && static_cast<std::size_t>(i) < of.bodies.size(); });
  }
  void archive(auto& ar) {
    ar("wall", wall, "body", body, "slip", slip, "roll", roll);
    ar.check(body.size() == size() && slip.size() == 3 * size() && (roll.empty() || roll.size() == slip.size()));
    for (const auto* x : {&slip, &roll}) ar.check(all_finite(x->data(), static_cast<std::ptrdiff_t>(x->size())));
  }
};

/// @tparam Law     Hooke, Hertz, GranHooke, or a type like them
/// @tparam Scalar  the state's
template <class Law, int dim = 3, class Scalar = double>
class Walls : public ForceTerm {
 public:
  using Springs = WallSprings<Scalar>;
  static constexpr const char* name = "walls";  ///< of its memory, in checkpoints
  using Memory = ContactMemory<Scalar, WallBodies<Scalar>, Springs>;
  // Through its memory the force depends on the time since the springs were known.
  static constexpr bool acts_on_each = true;
  static constexpr bool uses_velocity = true, uses_time = true;
  static constexpr Structure structure = Structure::network;
  static constexpr bool has_edges = true, is_symmetric = true;

  /// @throws std::invalid_argument where a wall has no normal, no thickness, or a type that isn't in the table
  Walls(Materials<Law> materials, std::vector<Wall<dim>> walls)
      : materials_{std::move(materials)}, walls_{std::move(walls)} {
    for (std::size_t w = 0; w < walls_.size(); ++w)
      std::visit([&](auto& wall) { check(wall, static_cast<std::ptrdiff_t>(w)); }, walls_[w]);
  }
  Walls(const Law& law, std::vector<Wall<dim>> walls) : Walls{Materials<Law>{law}, std::move(walls)} {}
  /// One by one: Walls{law, Plane{…}, SolidBox{…}}.
  template <class... Shape>
    requires(sizeof...(Shape) > 0 && (std::is_convertible_v<Shape, Wall<dim>> && ...))
  Walls(Materials<Law> materials, const Shape&... walls)
      : Walls{std::move(materials), std::vector<Wall<dim>>{walls...}} {}

  void begin(auto t, auto dt, const auto& y, Memory& memory) const {
    check_view(y);
    memory.begin(t, dt);
  }
  void add(auto t, const auto& y, const Memory& memory, auto& out) const {
    const auto springs = evaluate(t, y, memory);
    memory.remember(t, springs);
    constexpr bool spins = requires { y.omega; };
    for (std::size_t c = 0; c < springs->size(); ++c) {
      const auto i = static_cast<Eigen::Index>(springs->body[c]);
      for (int a = 0; a < dim; ++a) out.force(a, i) += result(c)[a];
      if constexpr (spins) {
        if constexpr (dim == 3)
          for (int a = 0; a < 3; ++a) out.torque(a, i) += result(c)[3 + a];
        else out.torque(0, i) += result(c)[5];
      }
    }
  }
  void commit(auto t, const auto& y, Memory& memory) const {
    if (memory.accept_single()) return;
    memory.remember(t, evaluate(t, y, memory));
    memory.accept_last();
  }
  /// Of the springs, normal and tangential and of rolling [energy].
  [[nodiscard]] Scalar energy(auto t, const auto& y, const Memory& memory) const {
    Memory copy = memory;
    const auto springs = evaluate(t, y, copy);
    Scalar sum{0};
    for (std::size_t c = 0; c < springs->size(); ++c)
      sum += stored_energy<Law>(broadcast_numbers<Scalar>(numbers(y, *springs, c)), touch_.overlap[c], touch_.rho[c],
                                springs->slip.data() + 3 * c,
                                springs->roll.empty() ? nullptr : springs->roll.data() + 3 * c);
    return sum;
  }
  /// See contact_tangent.hpp; how a box's normal turns about an edge is left out. Not for bodies with Spin.
  template <class View, class Sink>
    requires(!requires(const View& y) { y.omega; })
  void add_jacobian(auto t, const View& y, const Memory& memory, Sink& sink) const {
    const Memory copy = memory;
    const auto springs = evaluate(t, y, copy);
    for (std::size_t c = 0; c < springs->size(); ++c) {
      const Eigen::Index i = springs->body[c];
      const Triple<Scalar> n{touch_.nx[c], touch_.ny[c], touch_.nz[c]};
      const Scalar normal[3] = {n.x, n.y, n.z};
      const auto& velocity = std::visit(
          [](const auto& wall) -> const auto& { return wall.velocity; },
          walls_[static_cast<std::size_t>(springs->wall[c])]);
      Scalar v[3] = {0, 0, 0};
      for (int a = 0; a < dim; ++a) v[a] = y.v(a, i) - static_cast<Scalar>(velocity[a]);
      const Scalar* const slip = springs->slip.data() + 3 * c;
      PairTangent<Scalar> K, C;
      contact_tangent<Law>(broadcast_numbers<Scalar>(numbers(y, *springs, c)), n, touch_.overlap[c], Scalar{1},
                           {v[0], v[1], v[2]}, {slip[0], slip[1], slip[2]}, touch_.w[c], touch_.rho[c], copy.elapsed(t),
                           K, C);
      for (int b = 0; b < dim; ++b)
        for (int a = 0; a < dim; ++a) {
          const Scalar along = normal[a] * normal[b];
          sink.position(dim * i + a, dim * i + b, -K.along * along);
          sink.velocity(dim * i + a, dim * i + b, -C.along * along - C.across * (Scalar(a == b) - along));
        }
    }
  }

  /// [time] of the shortest impact of one of these bodies on a wall, at the speeds that they have now (preflight asks).
  [[nodiscard]] double contact_time(const auto& y) const { return shortest_impact<Law>(materials_, y, 1.0); }

  /// Bodies and walls that touched at the last evaluation.
  [[nodiscard]] std::int64_t touching() const { return static_cast<std::int64_t>(touch_.overlap_count); }

 private:
  static constexpr int width = native_width<Scalar>;
  using P = Pack<Scalar, width>;
  using Vector = Eigen::Matrix<Scalar, dim, 1>;

  static void check_view(const auto& y) {
    static_assert(
        requires { y.body, y.v; }, "phistep: Walls need Particles: bodies with radii");
    static_assert(std::is_same_v<typename std::remove_cvref_t<decltype(y.r)>::Scalar, Scalar> &&
                      std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime == dim,
                  "phistep: Walls<Law, dim, Scalar> must be of the state's dimension and number type");
  }
  [[noreturn]] static void complain(std::ptrdiff_t wall, const char* what) {
    throw std::invalid_argument("phistep: wall " + std::to_string(wall) + what);
  }
  void check_type(int type, std::ptrdiff_t w) const {
    if (type < 0 || (materials_.types() > 0 && type >= materials_.types()))
      complain(w, " is of a type that the table of materials doesn't have");
  }
  void check(Plane<dim>& wall, std::ptrdiff_t w) const {
    const double length = wall.normal.norm();
    if (!(length > 0) || !std::isfinite(length) || !wall.point.allFinite() || !wall.velocity.allFinite())
      complain(w, " needs a finite point and velocity, and a normal");
    wall.normal /= length;
    check_type(wall.type, w);
  }
  void check(SolidBox<dim>& wall, std::ptrdiff_t w) const {
    if (!wall.center.allFinite() || !wall.half.allFinite() || !(wall.half.minCoeff() > 0) || !wall.velocity.allFinite())
      complain(w, " needs a finite center and velocity, and edges > 0");
    if (!((wall.axes.transpose() * wall.axes).isIdentity(1e-9))) complain(w, " needs orthonormal axes");
    check_type(wall.type, w);
  }

  /// From the wall's nearest point to r: sets the unit normal, returns the distance (< 0 inside).
  [[nodiscard]] static Scalar approach(const Plane<dim>& wall, const Vector& r, Vector& n) {
    n = wall.normal.template cast<Scalar>();
    return n.dot(r - wall.point.template cast<Scalar>());
  }
  [[nodiscard]] static Scalar approach(const SolidBox<dim>& wall, const Vector& r, Vector& n) {
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

  /// One number a contact each, filled up to whole packs; and forces and torques, 6 numbers a contact.
  struct Touch {
    std::vector<Scalar> nx, ny, nz, overlap, arm, rho, w;
    std::vector<Scalar> result;
    std::size_t overlap_count = 0;
    void clear() {
      for (auto* x : {&nx, &ny, &nz, &overlap, &arm, &rho, &w}) x->clear();
    }
  };
  [[nodiscard]] const Scalar* result(std::size_t c) const { return &touch_.result[6 * c]; }
  [[nodiscard]] int type_of(std::size_t w) const {
    return std::visit([](const auto& wall) { return wall.type; }, walls_[w]);
  }
  [[nodiscard]] const ContactNumbers<double>& numbers(const auto& y, const Springs& springs, std::size_t c) const {
    return materials_(y.body.type_of(springs.body[c]), type_of(static_cast<std::size_t>(springs.wall[c])));
  }

  template <class View>
  std::shared_ptr<Springs> evaluate(Scalar t, const View& y, const Memory& memory) const {
    constexpr bool spins = requires { y.omega; };
    check_view(y);
    prepare(y, memory);
    auto springs = tables_.take();
    springs->clear();
    find_touching(y, *springs);
    springs->slip.assign(3 * springs->size(), Scalar{0});
    recall(memory.springs->slip, *memory.springs, springs->slip, *springs);
    if (spins && materials_.rolls()) {
      springs->roll.assign(3 * springs->size(), Scalar{0});
      recall(memory.springs->roll, *memory.springs, springs->roll, *springs);
      compute<spins, spins>(y, memory.elapsed(t), *springs);
    } else {
      compute<spins, false>(y, memory.elapsed(t), *springs);
    }
    return springs;
  }

  template <class View>
  void prepare(const View& y, const Memory& memory) const {
    const std::uint64_t body = y.body.serial;
    if (memory.places && memory.body == body && memory.places->bodies.size() == static_cast<std::size_t>(y.r.cols()))
      return;
    if (memory.places == nullptr || !memory.places->bodies.are(y.body)) {
      check_bodies(y.body, y.r.cols());
      for (Eigen::Index i = 0; i < y.r.cols(); ++i) materials_.check_type(y.body.type_of(i), i);
      std::vector<std::int32_t> order(static_cast<std::size_t>(y.r.cols()));
      for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
      auto places = std::make_shared<WallBodies<Scalar>>();
      places->bodies.assign(y.body, std::move(order));
      auto springs = std::make_shared<Springs>();
      if (memory.places) carry(*memory.places, *memory.springs, *places, *springs, memory.dormant);
      memory.places = std::move(places);
      memory.springs = std::move(springs);
    }
    memory.body = body;
  }

  /// The springs of bodies that are still there; their order stays that of the user. Those of bodies held still are not
  /// computed, and lie dormant.
  static void carry(const WallBodies<Scalar>& from, const Springs& old, const WallBodies<Scalar>& to, Springs& springs,
                    std::shared_ptr<const DormantSprings<Scalar>>& dormant) {
    const SlotsById by_id{to.bodies.id};
    using Three = std::array<Scalar, 3>;
    struct Kept {
      std::int32_t wall, body;
      Three slip, roll;
    };
    std::vector<Kept> kept;
    DormantSprings<Scalar> asleep;
    const auto keep = [&](std::int64_t id, std::int64_t wall, const Three& slip, const Three& roll) {
      const std::int32_t i = by_id(id);
      if (i < 0) return;
      if (to.bodies.inverse_mass[static_cast<std::size_t>(i)] > Scalar{0})
        kept.push_back({static_cast<std::int32_t>(wall), i, slip, roll});
      else asleep.contacts.push_back({id, wall, slip, roll});
    };
    const bool has_dormant = dormant && !dormant->contacts.empty();
    if (has_dormant)
      for (const auto& one : dormant->contacts) keep(one.a, one.b, one.slip, one.roll);
    for (std::size_t c = 0; c < old.size(); ++c) {
      Three slip{}, roll{};
      for (std::size_t a = 0; a < 3; ++a) {
        slip[a] = old.slip[3 * c + a];
        if (!old.roll.empty()) roll[a] = old.roll[3 * c + a];
      }
      keep(from.bodies.id[static_cast<std::size_t>(old.body[c])], old.wall[c], slip, roll);
    }
    std::sort(kept.begin(), kept.end(), [](const Kept& a, const Kept& b) {
      return std::pair{a.wall, a.body} < std::pair{b.wall, b.body};
    });
    for (const Kept& k : kept) {
      springs.wall.push_back(k.wall);
      springs.body.push_back(k.body);
      springs.slip.insert(springs.slip.end(), k.slip.begin(), k.slip.end());
      if (!old.roll.empty() || has_dormant) springs.roll.insert(springs.roll.end(), k.roll.begin(), k.roll.end());
    }
    if (has_dormant || !asleep.contacts.empty())
      dormant = std::make_shared<const DormantSprings<Scalar>>(std::move(asleep));
  }

  template <class View>
  void find_touching(const View& y, Springs& springs) const {
    touch_.clear();
    for (std::size_t w = 0; w < walls_.size(); ++w)
      std::visit(
          [&](const auto& wall) {
            Vector n;
            for (Eigen::Index i = 0; i < y.r.cols(); ++i) {
              const Scalar radius = y.body.radius[i], distance = approach(wall, y.r.col(i), n);
              // Not a number: it touches, so that the force says so.
              if (distance >= radius || y.body.is_still(i)) continue;
              springs.wall.push_back(static_cast<std::int32_t>(w));
              springs.body.push_back(static_cast<std::int32_t>(i));
              touch_.nx.push_back(n[0]);
              touch_.ny.push_back(n[1]);
              touch_.nz.push_back(dim == 3 ? n[dim - 1] : Scalar{0});
              touch_.overlap.push_back(radius - distance);
              touch_.arm.push_back(has_full_arms<Law> ? Scalar{1} : distance / radius);
              touch_.rho.push_back(Scalar{1} / radius);
              touch_.w.push_back(Scalar{1} / y.body.mass[i]);
            }
          },
          walls_[w]);
    touch_.overlap_count = springs.size();
    // A whole pack more, with numbers that do no harm.
    for (auto* x : {&touch_.nx, &touch_.ny, &touch_.nz, &touch_.overlap, &touch_.arm, &touch_.rho, &touch_.w})
      x->resize(springs.size() + width, Scalar{1});
  }

  /// Both lists are sorted.
  static void recall(const std::vector<Scalar>& old, const Springs& from, std::vector<Scalar>& to, const Springs& now) {
    if (old.empty()) return;
    std::size_t k = 0;
    for (std::size_t c = 0; c < now.size(); ++c) {
      while (k < from.size() &&
             (from.wall[k] < now.wall[c] || (from.wall[k] == now.wall[c] && from.body[k] < now.body[c])))
        ++k;
      if (k < from.size() && from.wall[k] == now.wall[c] && from.body[k] == now.body[c])
        for (std::size_t a = 0; a < 3; ++a) to[3 * c + a] = old[3 * k + a];
    }
  }

  template <bool spins, bool rolls, class View>
  void compute(const View& y, Scalar elapsed, Springs& springs) const {
    const std::size_t count = springs.size();
    touch_.result.resize(6 * count);
    for (std::size_t c = 0; c < count; c += width) {
      const std::size_t lanes = std::min<std::size_t>(width, count - c);
      const auto index = [&](int l) { return c + std::min(static_cast<std::size_t>(l), lanes - 1); };
      const auto column = [&](int l) { return static_cast<Eigen::Index>(springs.body[index(l)]); };
      const auto wall = [&](int l) -> const auto& { return walls_[static_cast<std::size_t>(springs.wall[index(l)])]; };
      const auto load = [&](const std::vector<Scalar>& x) { return P::load(&x[c]); };
      const auto triple = [&](const std::vector<Scalar>& x) {
        const auto component = [&](std::size_t a) { return P::make([&](int l) { return x[3 * index(l) + a]; }); };
        return Triple<P>{component(0), component(1), component(2)};
      };
      const auto speed = [&](int a) {
        return P::make([&](int l) {
          return a >= dim
                     ? Scalar{0}
                     : y.v(a, column(l)) -
                           static_cast<Scalar>(std::visit([a](const auto& of) { return of.velocity[a]; }, wall(l)));
        });
      };
      ContactPoint<P> at{{load(touch_.nx), load(touch_.ny), load(touch_.nz)},
                         load(touch_.overlap),
                         load(touch_.arm),
                         {speed(0), speed(1), speed(2)},
                         {P(0), P(0), P(0)},
                         load(touch_.w),
                         load(touch_.rho),
                         {P(0), P(0), P(0)}};
      if constexpr (spins) {
        const auto turning = [&](int a) {
          return P::make([&](int l) {
            if constexpr (dim == 3) return y.omega(a, column(l));
            else return a == 2 ? y.omega(0, column(l)) : Scalar{0};
          });
        };
        at.turning = {turning(0), turning(1), turning(2)};
        at.u = (P(1) / at.rho) * at.turning;
      }
      const ContactNumbers<double>* of[width];
      for (int l = 0; l < width; ++l) of[l] = &numbers(y, springs, index(l));
      ContactSprings<P> springs_at{triple(springs.slip), {P(0), P(0), P(0)}};
      if constexpr (rolls) springs_at.roll = triple(springs.roll);
      const auto f = contact_force<spins, rolls, Law>(lane_numbers<P>(of), at, P(elapsed), springs_at);
      for (std::size_t l = 0; l < lanes; ++l) {
        const int k = static_cast<int>(l);
        const auto put = [k](Scalar* to, const Triple<P>& x) { to[0] = x.x[k], to[1] = x.y[k], to[2] = x.z[k]; };
        Scalar* const to = &touch_.result[6 * (c + l)];
        put(to, f.force);
        put(&springs.slip[3 * (c + l)], springs_at.slip);
        if constexpr (spins) {
          Triple<P> torque = (P(1) / at.rho) * f.twist;
          if constexpr (rolls) torque = torque + f.torque;
          put(to + 3, torque);
        }
        if constexpr (rolls) put(&springs.roll[3 * (c + l)], springs_at.roll);
      }
    }
  }

  Materials<Law> materials_;
  std::vector<Wall<dim>> walls_;
  mutable Scratch<Touch> touch_;
  mutable Recycled<Springs> tables_;
};
template <class Law, int dim>
Walls(const Law&, std::vector<Wall<dim>>) -> Walls<Law, dim>;
template <class Law, int dim>
Walls(Materials<Law>, std::vector<Wall<dim>>) -> Walls<Law, dim>;
template <class Law, int dim, template <int> class Shape, class... Rest>
Walls(const Law&, const Shape<dim>&, const Rest&...) -> Walls<Law, dim>;
template <class Law, int dim, template <int> class Shape, class... Rest>
Walls(Materials<Law>, const Shape<dim>&, const Rest&...) -> Walls<Law, dim>;

}  // namespace phistep::inline PHISTEP_ABI
