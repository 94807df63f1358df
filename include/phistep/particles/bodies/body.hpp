/// @file
/// What particles have that doesn't change during a step: masses, radii, types, charges, the box around them. And the blocks that they
/// may have beside r and v: each names its part of the state, or a force's view, and of the rate, and its masses.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/update.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The region that particles live in: along each axis open or periodic; walls are force terms (particles/walls/walls.hpp).
/// Positions are never wrapped by the library: along a periodic axis they run on, and forces see the nearest images.
template <class Scalar, int dim>
struct Box {
  using Vector = Eigen::Matrix<Scalar, dim, 1>;

  Vector lower = Vector::Zero();        ///< [length], where the axis is periodic
  Vector upper = Vector::Zero();        ///< [length], likewise
  std::array<bool, dim> is_periodic{};  ///< an axis that isn't is open: nothing ends there

  [[nodiscard]] static Box open() { return {}; }
  /// Periodic along every axis.
  [[nodiscard]] static Box periodic(const Vector& lower, const Vector& upper) {
    Box box{lower, upper, {}};
    box.is_periodic.fill(true);
    return box;
  }
  [[nodiscard]] Vector length() const { return upper - lower; }
  [[nodiscard]] bool is_open() const { return is_periodic == std::array<bool, dim>{}; }

  /// @throws std::invalid_argument unless every periodic axis has a length that is finite and > 0
  void check() const {
    for (int a = 0; a < dim; ++a)
      if (periodic_at(a) && !(std::isfinite(upper[a] - lower[a]) && upper[a] > lower[a]))
        throw std::invalid_argument(
            "phistep: a periodic box needs finite lower < upper, and a finite length, along axis " + std::to_string(a));
  }

  /// r between lower and upper [length].
  [[nodiscard]] Vector wrapped(Vector r) const {
    for (int a = 0; a < dim; ++a)
      if (periodic_at(a)) {
        const Scalar size = upper[a] - lower[a];
        r[a] -= size * std::floor((r[a] - lower[a]) / size);
        if (r[a] >= upper[a]) r[a] -= size;  // rounding may put a position just below `lower` on `upper` itself
      }
    return r;
  }
  /// The shortest of a difference's images [length].
  [[nodiscard]] Vector nearest(Vector d) const {
    for (int a = 0; a < dim; ++a)
      if (periodic_at(a)) d[a] -= (upper[a] - lower[a]) * std::round(d[a] / (upper[a] - lower[a]));
    return d;
  }

  void archive(auto& ar) { ar("lower", lower, "upper", upper, "is_periodic", is_periodic); }
  bool operator==(const Box&) const = default;

 private:
  [[nodiscard]] bool periodic_at(int axis) const { return is_periodic[static_cast<std::size_t>(axis)]; }
};

/// Ids end below this: however many particles come after the largest, there are numbers for them.
inline constexpr std::int64_t largest_id = std::int64_t{1} << 62;

/// id ↦ the number of the particle that has it, or −1. @param ids  by number  @param order  k ↦ a number: all of them, mostly by their ids
template <class Order = std::identity>
[[nodiscard]] auto number_by_id(const std::vector<std::int64_t>& ids, const Order& order = {}) {
  std::vector<std::pair<std::int64_t, std::size_t>> sorted;
  for (std::size_t k = 0; k < ids.size(); ++k) sorted.emplace_back(ids[order(k)], order(k));
  if (!std::is_sorted(sorted.begin(), sorted.end())) std::sort(sorted.begin(), sorted.end());
  return [sorted = std::move(sorted)](std::int64_t of) {
    auto at = sorted.begin() + std::clamp<std::ptrdiff_t>(of, 0, static_cast<std::ptrdiff_t>(sorted.size()));
    if (at == sorted.end() || at->first != of)  // it isn't the user's index, as most are
      at = std::lower_bound(sorted.begin(), sorted.end(), std::pair{of, std::size_t{0}});
    return at != sorted.end() && at->first == of ? static_cast<std::int32_t>(at->second) : -1;
  };
}

/// Properties of particles: immutable, shared between a state and its copies, replaced by a new object where one is changed. A column has
/// a value for each particle, or none.
template <class Scalar, int dim>
struct Body {
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  Column mass;                      ///< [mass]
  Column radius;                    ///< [length], or empty
  Eigen::VectorXi type;             ///< an index into tables of materials, or empty: all 0
  Column charge;                    ///< [charge], or empty
  Column heat_capacity;             ///< [energy/temperature], or empty: 1
  std::vector<std::int64_t> id;     ///< of a particle, also when others are erased
  std::vector<std::uint8_t> still;  ///< 1: held as it is, at rest or at a constant velocity; empty: none is
  Box<Scalar, dim> box;             ///< open unless set
  Scalar inertia_factor = Scalar{2} / Scalar{5};  ///< I/(m R²): that of a solid sphere (a disc: ½)
  std::int64_t next_id = 0;                       ///< that of the next particle to be added
  std::uint64_t serial = 0;                       ///< unique to this body: what is made from it keeps this number

  [[nodiscard]] Eigen::Index size() const { return mass.size(); }
  [[nodiscard]] bool is_still(Eigen::Index i) const {
    return !still.empty() && still[static_cast<std::size_t>(i)] != 0;
  }
  /// I of particle i [mass·length²]
  [[nodiscard]] Scalar inertia(Eigen::Index i) const { return inertia_factor * mass[i] * (radius[i] * radius[i]); }
  [[nodiscard]] int type_of(Eigen::Index i) const { return type.size() == 0 ? 0 : type[i]; }

  /// @throws std::invalid_argument that names the particle with an impossible value
  void check() const {
    box.check();
    check_column(mass, "mass", true);
    check_column(radius, "radius", true);
    check_column(charge, "charge", false);
    check_column(heat_capacity, "heat capacity", true);
    for (Eigen::Index i = 0; i < type.size(); ++i)
      if (type[i] < 0) complain(i, "type", "be >= 0");
    if (!(inertia_factor > 0) || !std::isfinite(inertia_factor))
      throw std::invalid_argument("phistep: an inertia factor must be finite and > 0");
  }

  void archive(auto& ar) {
    ar("mass", mass, "radius", radius, "type", type, "charge", charge, "heat_capacity", heat_capacity, "id", id,
       "still", still, "box", box, "inertia_factor", inertia_factor, "next_id", next_id);
    const auto n = static_cast<std::size_t>(mass.size());
    ar.check(id.size() == n && (still.empty() || still.size() == n));
    ar.check(next_id >= 0 && next_id < largest_id + largest_id / 2);
    for (const Eigen::Index size : {radius.size(), type.size(), charge.size(), heat_capacity.size()})
      ar.check(size == 0 || size == mass.size());
  }

 private:
  void check_column(const Column& values, const char* name, bool positive) const {
    if (values.size() != static_cast<Eigen::Index>(id.size()) && (values.size() != 0 || &values == &mass))
      throw std::invalid_argument("phistep: " + std::to_string(values.size()) + " values of " + name + " for " +
                                  std::to_string(id.size()) + " particles");
    for (Eigen::Index i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]) || (positive && !(values[i] > 0)))
        complain(i, name, positive ? "be finite and > 0" : "be finite");
  }
  [[noreturn]] void complain(Eigen::Index i, const char* name, const char* must) const {
    throw std::invalid_argument("phistep: the " + std::string(name) + " of particle " + std::to_string(i) + " must " +
                                must);
  }
};

/// M of one block: a mass (inertia, capacity) m for each particle and its `rows` components. For particles held still or not computed
/// 1/m is 0, so that no force moves them.
template <class Scalar, int rows>
class ParticleMasses : public ComponentMass<ParticleMasses<Scalar, rows>> {
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

 public:
  /// @param mass  [mass] of each particle, finite and > 0
  /// @throws std::invalid_argument where one isn't
  ParticleMasses(const Column& mass, const std::vector<std::uint8_t>& still)
      : mass_(mass), inverse_(rows * mass.size()) {
    if (std::find_if(still.begin(), still.end(), [](auto held) { return held != 0; }) != still.end()) {
      std::vector<std::uint8_t> moves(still.size());
      for (std::size_t i = 0; i < still.size(); ++i) moves[i] = still[i] != 0 ? 0 : 1;
      auto movers = std::make_shared<ActiveSet>();
      movers->assign(moves, next_serial());
      movers_ = active_ = std::move(movers);
    }
    for (Eigen::Index i = 0; i < mass_.size(); ++i) static_cast<void>(checked_mass(mass_[i], i)), set_inverse(i);
  }

  /// From now on the forces on a set are computed, none of it held; null, or a set for another number of particles: all that aren't
  /// held. True where it has a particle that was not computed before.
  bool set_active(std::shared_ptr<const ActiveSet> now) {
    if (!now || now->size() != mass_.size()) now = movers_;
    const std::shared_ptr<const ActiveSet> before = std::exchange(active_, std::move(now));
    if (before == active_) return false;
    bool more = false;
    if (before && active_) {
      for_each_change(before->list(), active_->list(), [&](Eigen::Index i, bool joined) {
        set_inverse(i);
        more = more || joined;
      });
    } else {  // one of them is all particles
      const ActiveSet& some = active_ ? *active_ : *before;
      for (Eigen::Index i = 0; i < mass_.size(); ++i)
        if (!some.has(i)) set_inverse(i), more = more || !active_;
    }
    return more;
  }
  [[nodiscard]] const ActiveSet* active() const { return active_.get(); }
  LeftOut left_out;  ///< what a step knows of the particles outside the active set, for the forces that it calls

  [[nodiscard]] Scalar operator[](Eigen::Index component) const { return mass_[component / rows]; }
  [[nodiscard]] ComponentFactor<Scalar> h_over_mass(Scalar h) const { return {h, {inverse_.data()}}; }
  void subtract_product(const auto& x, auto&& out) const {
    for (Eigen::Index i = 0; i < out.size(); ++i) out[i] -= inertia(i) * x[i];
  }
  void for_each_inertia(Eigen::Index n, auto&& f) const {
    for (Eigen::Index i = 0; i < n; ++i) f(i, i, inertia(i));
  }

 private:
  /// In an implicit solve a held particle is very heavy: by a power of two beyond all rounding.
  [[nodiscard]] Scalar inertia(Eigen::Index i) const {
    const Scalar m = mass_[i / rows];
    return inverse_[i] > 0 ? m : std::ldexp(m, sizeof(Scalar) == 4 ? 40 : 120);
  }

  void set_inverse(Eigen::Index i) {
    const bool held = (movers_ && !movers_->has(i)) || (active_ && !active_->has(i));
    inverse_.template segment<rows>(rows * i).setConstant(held ? Scalar{0} : Scalar{1} / mass_[i]);
  }

  Column mass_, inverse_;
  std::shared_ptr<const ActiveSet> movers_, active_;  // those not held, null: all; of them, those computed
};

/// Particles that turn: I dω/dt = torque.
struct Spin {
  static constexpr const char* name = "omega";
  static constexpr int rows(int dim) { return dim == 3 ? 3 : 1; }
  template <class Numbers>
  struct Block {
    Numbers omega;  ///< angular velocities [1/time], 3 × N, or 1 × N in the plane
  };
  template <class Numbers>
  struct RateBlock {
    Numbers torque;  ///< [force·length]
  };
  static auto& block(auto& y) { return y.omega; }
  static auto& rate(auto& psi) { return psi.torque; }
  template <class Scalar, int dim>
  [[nodiscard]] static auto masses(const Body<Scalar, dim>& body) {
    if (body.radius.size() != body.size())
      throw std::invalid_argument("phistep: particles that turn need radii: set_radius(…)");
    return ParticleMasses<Scalar, rows(dim)>{
        (body.inertia_factor * body.mass.array() * body.radius.array().square()).matrix(), body.still};
  }
};

/// Particles with a temperature: c dT/dt = heat.
struct Temperature {
  static constexpr const char* name = "temperature";
  static constexpr int rows(int /*dim*/) { return 1; }
  template <class Numbers>
  struct Block {
    Numbers temperature;  ///< [temperature], 1 × N
  };
  template <class Numbers>
  struct RateBlock {
    Numbers heat;  ///< [power]
  };
  static auto& block(auto& y) { return y.temperature; }
  static auto& rate(auto& psi) { return psi.heat; }
  template <class Scalar, int dim>
  [[nodiscard]] static auto masses(const Body<Scalar, dim>& body) {
    using Column = typename Body<Scalar, dim>::Column;
    // A particle held in place takes up heat.
    return ParticleMasses<Scalar, 1>{
        body.heat_capacity.size() == 0 ? Column::Ones(body.size()).eval() : body.heat_capacity, {}};
  }
};

}}  // namespace phistep::PHISTEP_ABI
