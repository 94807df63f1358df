/// @file
/// What belongs to particles and doesn't change during a step: masses, radii, types, charges, the box.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/serial.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/update.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/bodies/box.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Ids end below this: however many particles come after the largest, there are numbers for them.
inline constexpr std::int64_t largest_id = std::int64_t{1} << 62;

/// Immutable, and shared between a state and the steppers' copies of it: another object says that something was changed.
/// Columns have a value a particle, or none where the scene doesn't need them.
template <class Scalar, int dim>
struct Body {
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  Column mass;                      ///< [mass]
  Column radius;                    ///< [length], or empty
  Eigen::VectorXi type;             ///< an index into tables of materials, or empty: all 0
  Column charge;                    ///< [charge], or empty
  Column heat_capacity;             ///< [energy/temperature], or empty: 1
  std::vector<std::int64_t> id;     ///< who a particle is: stays its own when others are erased
  std::vector<std::uint8_t> still;  ///< 1: held as it is, at rest or at a constant velocity; empty: none is
  Box<Scalar, dim> box;             ///< open unless set
  Scalar inertia_factor = Scalar{2} / Scalar{5};  ///< I/(m R²): that of a solid sphere (a disc: ½)
  std::int64_t next_id = 0;                       ///< that of the next particle to be added
  std::uint64_t serial = 0;  ///< another number, another body: for those who remember what they made for one

  [[nodiscard]] Eigen::Index size() const { return mass.size(); }
  [[nodiscard]] bool is_still(Eigen::Index i) const {
    return !still.empty() && still[static_cast<std::size_t>(i)] != 0;
  }
  /// I of particle i [mass·length²]
  [[nodiscard]] Scalar inertia(Eigen::Index i) const { return inertia_factor * mass[i] * (radius[i] * radius[i]); }
  [[nodiscard]] int type_of(Eigen::Index i) const { return type.size() == 0 ? 0 : type[i]; }

  /// @throws std::invalid_argument that names the particle whose value can't be
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
    if (values.size() != 0 && values.size() != mass.size())
      throw std::invalid_argument("phistep: " + std::to_string(values.size()) + " values of " + name + " for " +
                                  std::to_string(mass.size()) + " particles");
    for (Eigen::Index i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i]) || (positive && !(values[i] > 0)))
        complain(i, name, positive ? "be finite and > 0" : "be finite");
  }
  [[noreturn]] void complain(Eigen::Index i, const char* name, const char* must) const {
    throw std::invalid_argument("phistep: the " + std::string(name) + " of particle " + std::to_string(i) + " must " +
                                must);
  }
};

/// M of one block: a mass (inertia, capacity) m a particle, the same for each of its `rows` components. Of particles held
/// still, and of those that are not computed, the inverse is 0, so that no force moves them; their weight is that of their
/// mass.
template <class Scalar, int rows>
class ParticleMasses {
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

 public:
  static constexpr Structure structure = Structure::diagonal;
  static constexpr bool is_matrix = false;

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
    for (Eigen::Index i = 0; i < mass_.size(); ++i) {
      if (!(mass_[i] > 0) || !std::isfinite(mass_[i]) || !std::isfinite(1 / mass_[i]))
        throw std::invalid_argument("phistep: the mass of particle " + std::to_string(i) +
                                    " must be finite and > 0, and so must one over it");
      set_inverse(i);
    }
  }

  /// Those whose forces are computed from now on, none of them held; null, or a set for another number of particles: all that
  /// aren't held. True where one is that was not before.
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
  /// What a step knows of the particles outside the active set, for the forces that it calls.
  void set_left_out(const LeftOut& left_out) { left_out_ = left_out; }
  [[nodiscard]] const LeftOut& left_out() const { return left_out_; }

  /// [mass] of particle i
  [[nodiscard]] Scalar of(Eigen::Index i) const { return mass_[i]; }
  [[nodiscard]] Scalar operator[](Eigen::Index component) const { return mass_[component / rows]; }
  [[nodiscard]] ComponentFactor<Scalar> scaled(Scalar h) const { return {h, {inverse_.data()}}; }
  void subtract_product(const auto& x, auto&& out) const {
    for (Eigen::Index i = 0; i < out.size(); ++i) out[i] -= inertia(i) * x[i];
  }
  void for_each_entry(Eigen::Index n, auto&& f) const {
    for (Eigen::Index i = 0; i < n; ++i) f(i, i, mass_[i / rows]);
  }
  void for_each_inertia(Eigen::Index n, auto&& f) const {
    for (Eigen::Index i = 0; i < n; ++i) f(i, i, inertia(i));
  }
  void add_product(auto&& x, auto& out) const {
    for_each_range(out.size(), 64, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) out.data()[i] += mass_[i / rows] * x(i);
    });
  }

 private:
  /// In an implicit solve something held is something very heavy: by a power of two beyond all rounding.
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
  LeftOut left_out_;
};

}}  // namespace phistep::PHISTEP_ABI
