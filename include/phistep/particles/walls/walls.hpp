/// @file
/// Walls: planes and solid boxes that don't move, with the contact laws of bodies (contact_law.hpp).
///
///     Walls walls{Hooke{.stiffness = 1e5, .friction = 0.5}, Plane<3>{.point = …, .normal = …}, SolidBox<3>{…}};
///
/// A wall is a body of infinite mass and radius: m* = m, R* = R. It pushes along the normal of the nearest of its points,
/// there where friction acts, too.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/scratch.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/particles/contacts/contact_bodies.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/contact_law.hpp"
#include "phistep/particles/contacts/contact_memory.hpp"
#include "phistep/particles/contacts/spring_table.hpp"
#include "phistep/particles/walls/touching_walls.hpp"
#include "phistep/particles/walls/wall_shapes.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The forces between spheres and walls, by the laws of contact.
/// @tparam Law     Hooke, Hertz, GranHooke, or a type like them
/// @tparam Scalar  the state's
template <class Law, int dim = 3, class Scalar = double>
class Walls : public ForceTerm {
 public:
  using Places = WallBodies<Scalar>;
  using Springs = SpringTable<Scalar, std::int64_t>;
  static constexpr const char* name = "walls";  ///< of its memory, in checkpoints
  using Memory = ContactMemory<Scalar, Places, std::int64_t>;
  // Through its memory the force depends on the time since the springs were known.
  static constexpr bool acts_on_each = true;
  static constexpr bool uses_velocity = true, uses_time = true;
  static constexpr bool computes_active_only = true;
  static constexpr Structure structure = Structure::network;
  static constexpr bool has_edges = true, is_symmetric = true;

  /// @throws std::invalid_argument where a wall has no normal, no thickness, or a type that isn't in the table
  Walls(Materials<Law> materials, std::vector<Wall<dim>> walls)
      : materials_{std::move(materials)}, walls_{std::move(walls)} {
    for (std::size_t w = 0; w < walls_.size(); ++w) {
      std::visit([w](auto& wall) { check_wall(wall, w); }, walls_[w]);
      if (type_of(w) < 0 || !materials_.has(type_of(w)))
        refuse_wall(w, " is of a type that the table of materials doesn't have");
    }
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
    memory.remember(
        t, evaluate(t, y, memory, active_set(y), [&](Eigen::Index i, const Scalar* force, const Scalar* torque) {
          for (int a = 0; a < dim; ++a) out.force(a, i) += force[a];
          if constexpr (requires { y.omega; }) {
            if constexpr (dim == 3)
              for (int a = 0; a < 3; ++a) out.torque(a, i) += torque[a];
            else out.torque(0, i) += torque[2];
          }
        }));
  }
  void commit(auto t, const auto& y, Memory& memory) const {
    memory.commit([&] { return evaluate(t, y, memory, active_set(y)); });
  }
  /// Of the springs, normal and tangential and of rolling [energy].
  [[nodiscard]] Scalar energy(auto t, const auto& y, const Memory& memory) const {
    const Memory copy = memory;
    const auto springs = evaluate(t, y, copy, nullptr);
    Scalar sum{0};
    for (std::size_t c = 0; c < springs->size(); ++c)
      sum += stored_energy<Law, Scalar>(broadcast_numbers<Scalar>(numbers(y, springs->place[c])), touch_.overlap[c],
                                        touch_.rho[c], {springs->slip[c], springs->roll[c]});
    return sum;
  }
  /// See contact_kernel.hpp; how a box's normal turns about an edge is left out. Not for bodies with Spin.
  template <class View, class Sink>
    requires(!requires(const View& y) { y.omega; })
  void add_jacobian(auto t, const View& y, const Memory& memory, Sink& sink) const {
    const Memory copy = memory;
    const auto springs = evaluate(t, y, copy, active_set(y));
    for (std::size_t c = 0; c < springs->size(); ++c) {
      const std::int64_t place = springs->place[c];
      const Eigen::Index i = Places::body_of(place);
      const Scalar normal[3] = {touch_.nx[c], touch_.ny[c], touch_.nz[c]};
      Scalar v[3] = {0, 0, 0};
      for (int a = 0; a < dim; ++a) v[a] = speed(y, place, a);
      PairTangent<Scalar> K, C;
      contact_tangent<Law>(broadcast_numbers<Scalar>(numbers(y, place)), {normal[0], normal[1], normal[2]},
                           touch_.overlap[c], Scalar{1}, {v[0], v[1], v[2]}, springs->slip[c], touch_.w[c],
                           touch_.rho[c], copy.elapsed(t), K, C);
      for (int b = 0; b < dim; ++b)
        for (int a = 0; a < dim; ++a) {
          const Scalar along = normal[a] * normal[b];
          sink.position(dim * i + a, dim * i + b, -K.along * along);
          sink.velocity(dim * i + a, dim * i + b, -C.along * along - C.across * (Scalar(a == b) - along));
        }
    }
  }

  /// [time] of the shortest impact of one of these bodies on a wall, at the speeds that they have now: for preflight.
  [[nodiscard]] double contact_time(const auto& y) const { return shortest_impact<Law>(materials_, y, 1.0); }

  /// Bodies and walls that touched at the last evaluation.
  [[nodiscard]] std::int64_t touching() const { return touch_.count(); }

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
  [[nodiscard]] int type_of(std::size_t w) const {
    return std::visit([](const auto& wall) { return wall.type; }, walls_[w]);
  }
  [[nodiscard]] const ContactNumbers<double>& numbers(const auto& y, std::int64_t place) const {
    return materials_(y.body.type_of(Places::body_of(place)),
                      type_of(static_cast<std::size_t>(Places::wall_of(place))));
  }
  /// A component of a body's velocity against its wall's.
  [[nodiscard]] Scalar speed(const auto& y, std::int64_t place, int a) const {
    if (a >= dim) return Scalar{0};
    const auto& wall = walls_[static_cast<std::size_t>(Places::wall_of(place))];
    return y.v(a, Places::body_of(place)) -
           static_cast<Scalar>(std::visit([a](const auto& of) { return of.velocity[a]; }, wall));
  }

  struct Nowhere {
    void operator()(auto&&...) const {}
  };
  /// Springs at (t, y); put(i, force, torque) for each contact.
  /// @param active  of these bodies; null: of all
  template <class View, class Put = Nowhere>
  std::shared_ptr<Springs> evaluate(Scalar t, const View& y, const Memory& memory, const ActiveSet* active,
                                    const Put& put = {}) const {
    constexpr bool spins = requires { y.omega; };
    const bool rolls = spins && materials_.rolls();
    check_view(y);
    prepare(y, memory, rolls);
    if (active != nullptr) touch_.update(walls_.size(), *active);
    memory.part(
        number_of(active), [active](std::int64_t place) { return active->has(Places::body_of(place)); }, tables_,
        touch_.before(), touch_.joined());
    auto springs = tables_.take();
    touch_.find(walls_, y, active, *memory.springs, *springs, rolls);
    if (rolls) compute<spins, spins>(y, *memory.springs, *springs, memory.elapsed(t), put);
    else compute<spins, false>(y, *memory.springs, *springs, memory.elapsed(t), put);
    springs->close();
    return springs;
  }

  template <class View>
  void prepare(const View& y, const Memory& memory, bool rolls) const {
    const auto& body = y.body;
    if (memory.places && memory.body == body.serial &&
        memory.places->bodies.size() == static_cast<std::size_t>(y.r.cols()))
      return;
    materials_.check_types(body);
    if (memory.places && memory.places->bodies.are(body)) return memory.adopt(body.serial, rolls, tables_);
    check_bodies(body, y.r.cols());
    memory.join(tables_);
    std::vector<std::int32_t> order(static_cast<std::size_t>(y.r.cols()));
    std::iota(order.begin(), order.end(), 0);
    auto places = std::make_shared<Places>();
    places->bodies.assign(body, std::move(order));
    memory.springs = carried(memory, *places, rolls);
    memory.places = std::move(places);
    memory.body = body.serial;
  }
  /// The springs of bodies that are still there; their order stays that of the user. Those of bodies held still are not
  /// computed, and lie dormant.
  [[nodiscard]] static std::shared_ptr<const Springs> carried(const Memory& memory, const Places& to, bool rolls) {
    using Carried = CarriedSprings<Springs>;
    Carried carried;
    const SlotsById by_id{to.bodies.id};
    const auto carry = [&](std::int64_t id, std::int64_t wall, const ContactSprings<Scalar>& springs) {
      const std::int32_t i = by_id(id);
      if (i < 0) return;
      if (to.bodies.inverse_mass[static_cast<std::size_t>(i)] > Scalar{0})
        carried.carry_to(Places::place(wall, i), springs);
      else carried.lay_down(id, wall, springs);
    };
    if (memory.dormant) Carried::for_each(*memory.dormant, carry);
    if (memory.places)
      Carried::for_each(*memory.springs, [&](std::size_t c, const auto& springs) {
        const std::int64_t place = memory.springs->place[c];
        carry(memory.places->bodies.id[static_cast<std::size_t>(Places::body_of(place))], Places::wall_of(place),
              springs);
      });
    auto springs = std::make_shared<Springs>();
    carried.finish(*springs, rolls, memory.dormant);
    return springs;
  }

  template <bool spins, bool rolls, class View>
  void compute(const View& y, const Springs& before, Springs& after, Scalar elapsed, auto& put) const {
    const std::size_t count = after.size();
    for (std::size_t c = 0; c < count; c += width) {
      const std::size_t lanes = std::min<std::size_t>(width, count - c);
      const auto place = [&](int l) { return after.place[c + std::min(static_cast<std::size_t>(l), lanes - 1)]; };
      const auto load = [&](const std::vector<Scalar>& x) { return P::load(&x[c]); };
      const auto triple = [](auto&& component) {
        const auto pack = [&](int a) { return P::make([&](int l) { return component(a, l); }); };
        return Triple<P>{pack(0), pack(1), pack(2)};
      };
      ContactPoint<P> at{{load(touch_.nx), load(touch_.ny), load(touch_.nz)},
                         load(touch_.overlap),
                         has_full_arms<Law> ? P(1) : load(touch_.arm),
                         triple([&](int a, int l) { return speed(y, place(l), a); }),
                         {P(0), P(0), P(0)},
                         load(touch_.w),
                         load(touch_.rho),
                         {P(0), P(0), P(0)}};
      if constexpr (spins) {
        at.turning = triple([&](int a, int l) {
          const Eigen::Index i = Places::body_of(place(l));
          if constexpr (dim == 3) return y.omega(a, i);
          else return a == 2 ? y.omega(0, i) : Scalar{0};
        });
        at.u = (P(1) / at.rho) * at.turning;
      }
      const ContactNumbers<double>* of[width];
      for (int l = 0; l < width; ++l) of[l] = &numbers(y, place(l));
      const auto f =
          contact_force<spins, rolls, Law>(lane_numbers<P>(of), at, elapsed, before, &touch_.from[c], after, c);
      Triple<P> torque{P(0), P(0), P(0)};
      if constexpr (spins) torque = (P(1) / at.rho) * f.twist;
      if constexpr (rolls) torque = torque + f.torque;
      const auto lane = [](const Triple<P>& x, int l) { return std::array<Scalar, 3>{x.x[l], x.y[l], x.z[l]}; };
      for (int l = 0; l < static_cast<int>(lanes); ++l)
        put(Eigen::Index{Places::body_of(place(l))}, lane(f.force, l).data(), lane(torque, l).data());
    }
  }

  Materials<Law> materials_;
  std::vector<Wall<dim>> walls_;
  mutable Scratch<TouchingWalls<Scalar, dim>> touch_;
  mutable RecycledSprings<Springs> tables_;
};
template <class Law, int dim>
Walls(const Law&, std::vector<Wall<dim>>) -> Walls<Law, dim>;
template <class Law, int dim>
Walls(Materials<Law>, std::vector<Wall<dim>>) -> Walls<Law, dim>;
template <class Law, int dim, template <int> class Shape, class... Rest>
Walls(const Law&, const Shape<dim>&, const Rest&...) -> Walls<Law, dim>;
template <class Law, int dim, template <int> class Shape, class... Rest>
Walls(Materials<Law>, const Shape<dim>&, const Rest&...) -> Walls<Law, dim>;

}}  // namespace phistep::PHISTEP_ABI
