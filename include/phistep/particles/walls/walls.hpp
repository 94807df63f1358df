/// @file
/// Walls: planes and solid boxes that don't move, with the contact laws of bodies (contact_law.hpp).
///
///     Walls walls{Hooke{.stiffness = 1e5, .friction = 0.5}, Plane<3>{.point = …, .normal = …}, SolidBox<3>{…}};
///
/// A wall is a body of infinite mass and radius: m* = m, R* = R. Force and friction act at the nearest of its points.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/contact_law.hpp"
#include "phistep/particles/contacts/contact_memory.hpp"
#include "phistep/particles/contacts/contact_pairs.hpp"
#include "phistep/particles/contacts/spring_table.hpp"
#include "phistep/particles/walls/wall_shapes.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The forces between spheres and walls, by the laws of contact.
/// @tparam Law     Hooke, Hertz, GranHooke, or a type like them
/// @tparam Scalar  the state's
template <class Law, int dim = 3, class Scalar = double>
class Walls : public ContactTerm {
 public:
  using Places = WallBodies;
  using Springs = SpringTable<Scalar, std::int64_t, stiffens<Law>>;
  static constexpr const char* name = "walls";  ///< of its memory, in checkpoints
  using Memory = ContactMemory<Springs, Places>;
  static constexpr bool acts_on_each = true;

  /// @throws std::invalid_argument where a wall has no normal, no thickness, or a type that isn't in the table
  Walls(Materials<Law> materials, std::vector<Wall<dim>> walls)
      : materials_{std::move(materials)}, walls_{std::move(walls)} {
    for (std::size_t w = 0; w < walls_.size(); ++w) {
      std::visit([w](auto& wall) { check_wall(wall, w); }, walls_[w]);
      if (type_of(w) < 0 || !materials_.has(type_of(w)))
        refuse_wall(w, " is of a type that the table of materials doesn't have");
    }
  }
  /// One by one: Walls{law, Plane{…}, SolidBox{…}}.
  template <class... Shape>
    requires(sizeof...(Shape) > 0 && (std::is_convertible_v<Shape, Wall<dim>> && ...))
  Walls(Materials<Law> materials, const Shape&... walls)
      : Walls{std::move(materials), std::vector<Wall<dim>>{walls...}} {}

  void add(auto t, const auto& y, const Memory& memory, auto& out) const {
    memory.remember(
        t, evaluate(t, y, memory, active_set(y), [&](std::int64_t place, const Scalar* force, const Scalar* torque) {
          const Eigen::Index i = Places::body_of(place);
          for (int a = 0; a < dim; ++a) out.force(a, i) += force[a];
          if constexpr (HasSpin<decltype(y)>)
            for (int a = 0, n = Spin::rows(dim); a < n; ++a) out.torque(a, i) += torque[3 - n + a];
        }));
  }
  void commit(auto t, const auto& y, Memory& memory) const {
    memory.commit([&] { return evaluate(t, y, memory, active_set(y)); });
  }
  /// Energy of all springs, as the last step has left them [energy].
  [[nodiscard]] Scalar energy(auto t, const auto& y, const Memory& memory) const {
    const Memory copy = memory;
    const auto springs = evaluate(memory.near_by(t), y, copy, nullptr);
    Scalar sum{0};
    for (std::size_t c = 0; c < springs->size(); ++c)
      sum += stored_energy<Law>(numbers_in<Scalar>(numbers(y, springs->place[c])), touch_.points[c], (*springs)[c]);
    return sum;
  }
  /// On wall number w [force].
  [[nodiscard]] Eigen::Matrix<Scalar, dim, 1> force_on(std::size_t w, auto t, const auto& y,
                                                       const Memory& memory) const {
    Eigen::Matrix<Scalar, dim, 1> sum = Eigen::Matrix<Scalar, dim, 1>::Zero();
    const Memory copy = memory;
    evaluate(memory.near_by(t), y, copy, nullptr, [&](std::int64_t place, const Scalar* force, const Scalar*) {
      if (Places::wall_of(place) == static_cast<std::int64_t>(w))
        for (int a = 0; a < dim; ++a) sum[a] -= force[a];
    });
    return sum;
  }
  /// See contact_kernel.hpp; how a box's normal turns about an edge is left out. Not for bodies with Spin.
  template <class View, class Sink>
    requires(!HasSpin<View>)
  void add_jacobian(auto t, const View& y, const Memory& memory, Sink& sink) const {
    const Memory copy = memory;
    const auto springs = evaluate(t, y, copy, active_set(y));
    for (std::size_t c = 0; c < springs->size(); ++c) {
      const std::int64_t place = springs->place[c];
      const Eigen::Index i = Places::body_of(place);
      const ContactPoint<Scalar>& at = touch_.points[c];
      const Scalar normal[3] = {at.n.x, at.n.y, at.n.z};
      const auto [K, C] = contact_tangents<Law>(numbers_in<Scalar>(numbers(y, place)), at, Scalar{1},
                                                (*springs)[c].slip, copy.elapsed(t));
      for (int b = 0; b < dim; ++b)
        for (int a = 0; a < dim; ++a) {
          const Scalar along = normal[a] * normal[b];
          sink.position(dim * i + a, dim * i + b, -K.along * along);
          sink.velocity(dim * i + a, dim * i + b, -C.along * along - C.across * (Scalar(a == b) - along));
        }
    }
  }

  /// [time] of the shortest impact of one of these bodies on a wall, at the speeds that they have now: for preflight.
  [[nodiscard]] double contact_time(const auto& y) const { return impacts(y).shortest; }
  [[nodiscard]] Impacts impacts(const auto& y) const {
    double thinnest = std::numeric_limits<double>::infinity();
    for (const auto& wall : walls_)
      if (const auto* box = std::get_if<SolidBox<dim>>(&wall)) thinnest = std::min(thinnest, box->half.minCoeff());
    if (y.body.radius.size() > 0) thinnest += static_cast<double>(y.body.radius.minCoeff());
    return impacts_of<Law>(materials_, y, 1.0, thinnest);
  }

  /// Bodies and walls that touched at the last evaluation.
  [[nodiscard]] std::int64_t touching() const { return touch_.count; }

 private:
  static constexpr int width = native_width<Scalar>;
  using P = Pack<Scalar, width>;
  using Vector = Eigen::Matrix<Scalar, dim, 1>;

  [[nodiscard]] int type_of(std::size_t w) const {
    return std::visit([](const auto& wall) { return wall.type; }, walls_[w]);
  }
  [[nodiscard]] const ContactNumbers<double>& numbers(const auto& y, std::int64_t place) const {
    return materials_(y.body.type_of(Places::body_of(place)),
                      type_of(static_cast<std::size_t>(Places::wall_of(place))));
  }
  static constexpr auto nowhere = [](auto&&...) {};
  /// Springs at (t, y); put(place, force, torque) for each contact.
  /// @param active  of these bodies; null: of all
  template <class View, class Put = decltype(nowhere)>
  std::shared_ptr<Springs> evaluate(Scalar t, const View& y, const Memory& memory, const ActiveSet* active,
                                    const Put& put = nowhere) const {
    static_assert(HasBody<View>, "phistep: Walls need Particles: bodies with radii");
    static_assert(std::is_same_v<typename std::remove_cvref_t<decltype(y.r)>::Scalar, Scalar> &&
                      std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime == dim,
                  "phistep: Walls<Law, dim, Scalar> must be of the state's dimension and number type");
    constexpr bool spins = HasSpin<decltype(y)>;
    const bool rolls = spins && materials_.rolls();
    prepare(y, memory, rolls);
    memory.part(
        number_of(active), [active](std::int64_t place) { return active->has(Places::body_of(place)); }, tables_);
    auto springs = tables_.take();
    touch_.find(walls_, y, active, *memory.springs, *springs, rolls);
    if (rolls) compute<spins, spins>(y, *memory.springs, *springs, memory.elapsed(t), put);
    else compute<spins, false>(y, *memory.springs, *springs, memory.elapsed(t), put);
    springs->close();
    return springs;
  }

  void prepare(const auto& y, const Memory& memory, bool rolls) const {
    const auto& body = y.body;
    if (memory.places && memory.body == body.serial && body.size() == y.r.cols()) return;
    materials_.check_types(body);
    check_bodies(body, y.r.cols());
    if (memory.places && memory.places->id == body.id) memory.adopt(body.serial, rolls, tables_);
    else memory.move_to(std::make_shared<Places>(Places{body.id}), body.serial, rolls, tables_);
  }

  template <bool spins, bool rolls>
  void compute(const auto& y, const Springs& before, Springs& after, Scalar elapsed, auto& put) const {
    const std::size_t count = after.size();
    for (std::size_t c = 0; c < count; c += width) {
      const std::size_t lanes = std::min<std::size_t>(width, count - c);
      const auto place = [&](int l) { return after.place[c + std::min(static_cast<std::size_t>(l), lanes - 1)]; };
      auto at = in_lanes<ContactPoint, P, Scalar>([&](int l) -> const auto& {
        return touch_.points[c + static_cast<std::size_t>(l)];
      });
      if constexpr (has_full_arms<Law>) at.arm = P(1);
      at.u = (P(1) / at.rho) * at.turning;
      const auto law = in_lanes<ContactNumbers, P, double>([&](int l) -> const auto& { return numbers(y, place(l)); });
      auto springs = before.template load<rolls, P>(&touch_.from[c]);
      const auto f = contact_force<spins, rolls, Law>(law, at, P(elapsed), springs);
      after.template store<rolls>(springs, c);
      Triple<P> torque{P(0), P(0), P(0)};
      if constexpr (spins) torque = (P(1) / at.rho) * f.twist;
      if constexpr (rolls) torque = torque + f.torque;
      const auto lane = [](const Triple<P>& x, int l) { return std::array<Scalar, 3>{x.x[l], x.y[l], x.z[l]}; };
      for (int l = 0; l < static_cast<int>(lanes); ++l) put(place(l), lane(f.force, l).data(), lane(torque, l).data());
    }
  }

  Materials<Law> materials_;
  std::vector<Wall<dim>> walls_;
  mutable Scratch<TouchingWalls<Scalar, dim>> touch_;
  mutable RecycledSprings<Springs> tables_;
};
template <class Law, int dim>
Walls(const Law&, std::vector<Wall<dim>>) -> Walls<Law, dim>;
template <class Law, int dim, template <int> class Shape, class... Rest>
Walls(const Law&, const Shape<dim>&, const Rest&...) -> Walls<Law, dim>;
template <class Law, int dim, template <int> class Shape, class... Rest>
Walls(Materials<Law>, const Shape<dim>&, const Rest&...) -> Walls<Law, dim>;

}}  // namespace phistep::PHISTEP_ABI
