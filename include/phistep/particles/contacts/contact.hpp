/// @file
/// Contacts between bodies, with friction that remembers.
///
///     Particles<double, 3, Spin> grains{positions};
///     grains.set_mass(m).set_radius(R);
///     auto force = Gravity{Eigen::Vector3d{0, 0, -9.81}} + Contact{Hooke{.stiffness = 1e5, .restitution = 0.9, .friction = 0.5}};
///     PhiStepper stepper{grains, force, symplectic_euler};
///
/// The laws are in contact_law.hpp, the force in contact_kernel.hpp, what is remembered in contact_memory.hpp. Without Spin
/// there are no torques, and no rolling friction. The force depends on the velocities. A scheme that evaluates it once a
/// step passes over the bodies once: symplectic_euler, v⁺ = v + Δt M⁻¹Ψ(t, r, v), r⁺ = r + Δt v⁺, whose v is the velocity
/// half a step before r, and which is then what LAMMPS does with `fix nve/sphere`: velocity Verlet, its dashpots seeing the
/// velocity of half a step before.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/version.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/contact_law.hpp"
#include "phistep/particles/contacts/contact_memory.hpp"
#include "phistep/particles/contacts/contact_passes.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The forces between spheres that touch, friction and rolling resistance included.
/// @tparam Law     Hooke, Hertz, GranHooke, or a type like them
/// @tparam Scalar  the state's
template <class Law, class Scalar = double>
class Contact : public ForceTerm {
 public:
  using Pairs = ContactPairs<Scalar>;
  using Springs = SpringTable<Scalar>;
  static constexpr const char* name = "contact";  ///< of its memory, in checkpoints
  using Memory = ContactMemory<Scalar, Pairs>;
  // Through its memory the force depends on the time since the springs were known.
  static constexpr bool uses_velocity = true, uses_time = true;
  static constexpr bool computes_active_only = true;
  static constexpr Structure structure = Structure::network;
  static constexpr bool has_edges = true, is_symmetric = true;

  /// @param skin  [length] pairs are kept as long as no body has moved by half of it; 0: a fraction of the radii
  explicit Contact(Materials<Law> materials, double skin = 0) : passes_{std::move(materials), skin} {
    if (!(skin >= 0) || !std::isfinite(skin)) throw std::invalid_argument("phistep: a skin must be finite and >= 0");
  }
  explicit Contact(const Law& law, double skin = 0) : Contact{Materials<Law>{law}, skin} {}

  void begin(auto t, auto dt, const auto& y, Memory& memory) const {
    check_view(y);
    memory.begin(t, dt);
  }
  void add(auto t, const auto& y, const Memory& memory, auto& out) const {
    const auto springs = passes_.evaluate(t, y, memory, active_set(y));
    memory.remember(t, springs);
    passes_.give(y, out, *memory.places);
  }
  void commit(auto t, const auto& y, Memory& memory) const {
    memory.commit([&] { return passes_.evaluate(t, y, memory, active_set(y)); });
  }
  /// Of the springs, normal and tangential and of rolling [energy].
  [[nodiscard]] Scalar energy(auto t, const auto& y, const Memory& memory) const {
    const Memory copy = memory;
    const auto springs = passes_.evaluate(t, y, copy, nullptr);
    return passes_.energy(*copy.places, *springs);
  }

  /// f(i, j) for every pair that may touch before pair_changes() changes, by the user's indices; none acts before it does.
  static constexpr bool acts_by_touch = true;
  void for_each_pair(const Memory& memory, auto&& f) const {
    if (memory.places == nullptr) return;
    const auto& pairs = *memory.places;
    for (std::size_t p = 0; p < pairs.places(); ++p)
      f(Eigen::Index{pairs.bodies.particle[static_cast<std::size_t>(pairs.first[p])]},
        Eigen::Index{pairs.bodies.particle[static_cast<std::size_t>(pairs.second[p])]});
  }
  [[nodiscard]] std::int64_t pair_changes() const { return statistics().rebuilds; }

  /// Pairs, where the sink takes them: see contact_kernel.hpp. Not for bodies with Spin, whose torques
  /// are no pair's.
  template <class View, class Sink>
    requires(!requires(const View& y) { y.omega; })
  void add_jacobian(auto t, const View& y, const Memory& memory, Sink& sink) const {
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    const Memory copy = memory;
    const auto springs = passes_.evaluate(t, y, copy, active_set(y));
    passes_.for_each_tangent(*copy.places, *springs, copy.elapsed(t),
                             [&](Eigen::Index i, Eigen::Index j, const Scalar* n, const auto& K, const auto& C) {
                               put_pair<dim, true>(sink, i, j, n, K, C);
                             });
  }

  /// [time] of the shortest impact between two of these bodies, at the speeds that they have now: for preflight.
  [[nodiscard]] double contact_time(const auto& y) const { return shortest_impact<Law>(passes_.materials(), y, 0.5); }

  [[nodiscard]] const ContactStatistics& statistics() const { return passes_.statistics(); }

 private:
  template <class View>
  static void check_view(const View&) {
    static_assert(
        requires(const View& y) { y.body, y.v; }, "phistep: Contact needs Particles: bodies with radii");
    static_assert(std::is_same_v<typename std::remove_cvref_t<decltype(std::declval<View>().r)>::Scalar, Scalar>,
                  "phistep: Contact<Law, Scalar> must be of the state's number type: Contact<Hooke, float>{…}");
  }

  ContactPasses<Law, Scalar> passes_;
};
template <class Law>
Contact(const Law&, double = 0) -> Contact<Law>;
template <class Law>
Contact(Materials<Law>, double = 0) -> Contact<Law>;

}}  // namespace phistep::PHISTEP_ABI
