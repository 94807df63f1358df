/// @file
/// Contacts between bodies, with friction that remembers.
///
///     Particles<double, 3, Spin> grains{positions};
///     grains.set_mass(m).set_radius(R);
///     auto force = Gravity{Eigen::Vector3d{0, 0, -9.81}} + Contact{Hooke{.stiffness = 1e5, .restitution = 0.9, .friction = 0.5}};
///     PhiStepper stepper{grains, force, symplectic_euler};
///
/// Without Spin there are no torques, and no rolling friction. The force depends on velocities; symplectic_euler, v⁺ = v + Δt M⁻¹Ψ(t, r, v),
/// r⁺ = r + Δt v⁺, evaluates it once a step: its v is the velocity half a step before r, as in LAMMPS' `fix nve/sphere`, a velocity Verlet
/// whose dashpots take the velocity of half a step before.
///
/// An evaluation computes each pair once, in these passes:
///
///   gather    bodies into slots in cache order (contact_slots.hpp); the pairs are found anew where one moved too far
///   touch     which pairs touch
///   compute   the law for those (contact_kernel.hpp), a pack at a time, and its sum on each slot (touching_pairs.hpp)
///   give      from the slots to the user's order
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>
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
#include "phistep/particles/contacts/contact_search.hpp"
#include "phistep/particles/contacts/contact_slots.hpp"
#include "phistep/particles/contacts/spring_table.hpp"
#include "phistep/particles/contacts/touching_pairs.hpp"
#include "phistep/particles/neighbors/neighbor_list.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The forces between spheres that touch, friction and rolling resistance included.
/// @tparam Law     Hooke, Hertz, GranHooke, or a type like them
/// @tparam Scalar  the state's
template <class Law, class Scalar = double>
class Contact : public ContactTerm {
  using Pairs = ContactPairs<Scalar>;
  using Places = ContactPlaces<Scalar>;
  using Springs = SpringTable<Scalar, std::int32_t, stiffens<Law>>;

 public:
  static constexpr const char* name = "contact";  ///< of its memory, in checkpoints
  using Memory = ContactMemory<Springs, Places>;

  /// @param skin  [length] pairs are kept as long as no body has moved by half of it; 0: a fraction of the radii
  explicit Contact(Materials<Law> materials, double skin = 0) : materials_{std::move(materials)}, skin_{skin} {
    if (!(skin >= 0) || !std::isfinite(skin)) throw std::invalid_argument("phistep: a skin must be finite and >= 0");
  }

  void add(auto t, const auto& y, const Memory& memory, auto& out) const {
    memory.remember(t, evaluate(t, y, memory, active_set(y)));
    work_.sums.give(y, memory.places->pairs->bodies, out, active_set(y));
  }
  void commit(auto t, const auto& y, Memory& memory) const {
    memory.commit([&] { return evaluate(t, y, memory, active_set(y)); });
  }
  /// Energy of all springs, as the last step has left them [energy].
  [[nodiscard]] Scalar energy(auto t, const auto& y, const Memory& memory) const {
    const Memory copy = memory;
    const auto springs = evaluate(memory.near_by(t), y, copy, nullptr);
    Scalar sum{0};
    for (std::size_t c = 0; c < springs->size(); ++c) {
      const Meeting at = meet(*copy.places, springs->place[c]);
      if (at.point.w > 0) sum += stored_energy<Law>(at.numbers, at.point, (*springs)[c]);
    }
    return sum;
  }

  /// Σ (r_i − r_j)·F_i of the contacts [energy], for the pressure: friction has none along the line of centres
  [[nodiscard]] Scalar virial(auto t, const auto& y) const {
    const Memory anew;
    const auto springs = evaluate(t, y, anew, nullptr);
    Scalar sum{0};
    for (const std::int32_t place : springs->place) {
      const Meeting at = meet(*anew.places, place);
      const ContactPoint<Scalar>& p = at.point;
      const auto law = Law::response(at.numbers, p.overlap, dot(p.n, p.v), p.w, p.rho);
      if (at.point.w > 0) sum += at.distance * std::max(law.normal, at.numbers.least);
    }
    return sum;
  }

  /// f(i, j) for every pair that may touch before pair_changes() changes, by the user's indices; none acts before it does.
  static constexpr bool acts_by_touch = true;
  void for_each_pair(const Memory& memory, auto&& f) const {
    if (memory.places == nullptr) return;
    memory.places->for_each([&](std::int32_t, std::int32_t a, std::int32_t b) { f(user(memory, a), user(memory, b)); });
  }
  /// The ones of these that may come or go while pair_changes() stays.
  void for_each_late_pair(const Memory& memory, auto&& f) const {
    if (memory.places == nullptr) return;
    for (const auto& pair : memory.places->late) f(user(memory, pair.first), user(memory, pair.second));
  }
  [[nodiscard]] std::int64_t pair_changes() const { return statistics_.rebuilds; }

  /// See contact_kernel.hpp; pairs that don't touch have tangents of 0. Not for bodies with Spin, whose torques are no pair's.
  template <class View, class Sink>
    requires(!HasSpin<View>)
  void add_jacobian(auto t, const View& y, const Memory& memory, Sink& sink) const {
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    const Memory copy = memory;
    const auto springs = evaluate(t, y, copy, active_set(y));
    std::size_t c = 0;
    copy.places->for_each([&](std::int32_t place, std::int32_t i, std::int32_t j) {
      const Meeting at = meet(*copy.places, place);
      std::array<PairTangent<Scalar>, 2> K_C{};
      if (c < springs->size() && springs->place[c] == place)
        K_C = contact_tangents<Law>(at.numbers, at.point, at.distance, (*springs)[c++].slip, copy.elapsed(t));
      const Scalar n[3] = {at.point.n.x, at.point.n.y, at.point.n.z};
      put_pair<dim, true>(sink, user(copy, i), user(copy, j), n, K_C[0], K_C[1]);
    });
  }

  /// [time] of the shortest impact between two of these bodies, at the speeds that they have now: for preflight.
  [[nodiscard]] double contact_time(const auto& y) const { return impacts(y).shortest; }
  [[nodiscard]] Impacts impacts(const auto& y) const {
    const double least = y.body.radius.size() > 0 ? static_cast<double>(y.body.radius.minCoeff()) : 1;
    return impacts_of<Law>(materials_, y, 0.5, 2 * least);
  }

  [[nodiscard]] const ContactStatistics& statistics() const { return statistics_; }

 private:
  using P = Pack<Scalar, native_width<Scalar>>;
  struct Workspace {
    ContactSlots<Scalar> slots;
    TouchingPairs<Scalar> touching;
    SlotSums<Scalar> sums;
    ComputedPairs<Scalar> computed;
    std::tuple<ContactSearch<Scalar, 2>, ContactSearch<Scalar, 3>> late;
  };

  /// The user's index of the body with the internal number `slot`.
  [[nodiscard]] static Eigen::Index user(const Memory& memory, std::int32_t slot) {
    return memory.places->pairs->bodies.particle[static_cast<std::size_t>(slot)];
  }

  /// Springs at (t, y); forces and torques lie in the workspace.
  /// @param active  those that are computed, with all that acts on them; null: all
  std::shared_ptr<Springs> evaluate(Scalar t, const auto& y, const Memory& memory, const ActiveSet* active) const {
    static_assert(HasBody<decltype(y)>, "phistep: Contact needs Particles: bodies with radii");
    static_assert(std::is_same_v<typename std::remove_cvref_t<decltype(y.r)>::Scalar, Scalar>,
                  "phistep: Contact<Law, Scalar> must be of the state's number type: Contact<Hooke, float>{…}");
    constexpr bool spins = HasSpin<decltype(y)>;
    const bool rolls = spins && materials_.rolls();
    prepare(y, memory, rolls, active);
    const Places& places = *memory.places;
    const Pairs& pairs = *places.pairs;
    const PairRange range = active ? work_.computed.range() : pairs.range();
    memory.part(
        number_of(active), [this](std::int32_t place) { return work_.computed.has_pair(place); }, tables_,
        work_.computed.joined_since(memory.active));
    std::shared_ptr<Springs> springs = tables_.take();
    ++statistics_.evaluations;
    work_.touching.find(pairs.period, range, work_.slots, *memory.springs, *springs, rolls);
    work_.sums.clear(pairs.bodies.size(), active ? &work_.computed.slots() : nullptr, rolls);
    statistics_.pairs = static_cast<std::int64_t>(range.count);
    statistics_.touching = static_cast<std::int64_t>(springs->size());
    const auto compute = [&](auto&& numbers) {
      if (rolls) add_up<spins, spins>(places, *memory.springs, *springs, memory.elapsed(t), numbers);
      else add_up<spins, false>(places, *memory.springs, *springs, memory.elapsed(t), numbers);
    };
    if (materials_.types() == 0) {
      const auto all = in_lanes<ContactNumbers, P, double>([&](int) -> const auto& { return materials_(0, 0); });
      compute([&](const auto&...) { return all; });
    } else {
      compute([&](const std::int32_t* i, const std::int32_t* j) {
        const auto type = [&](std::int32_t slot) { return pairs.bodies.type_of(static_cast<std::size_t>(slot)); };
        const auto of = [&](int l) -> const auto& { return materials_(type(i[l]), type(j[l])); };
        return in_lanes<ContactNumbers, P, double>(of);
      });
    }
    springs->close();
    return springs;
  }
  /// Two bodies of the last evaluation; w = 0: both are held still.
  struct Meeting {
    ContactPoint<Scalar> point;  ///< but for spins
    Scalar distance;
    ContactNumbers<Scalar> numbers;
  };
  [[nodiscard]] Meeting meet(const Places& places, std::int32_t place) const {
    const auto slots = places.slots(place);
    const auto i = static_cast<std::size_t>(slots[0]), j = static_cast<std::size_t>(slots[1]);
    const auto& bodies = places.pairs->bodies;
    const auto difference = [i, j](const std::vector<Scalar>& x) {
      return Triple<Scalar>{x[4 * i] - x[4 * j], x[4 * i + 1] - x[4 * j + 1], x[4 * i + 2] - x[4 * j + 2]};
    };
    const Triple<Scalar> d = nearest_image<Scalar>(places.pairs->period)(difference(work_.slots.position));
    const Scalar distance = std::sqrt(dot(d, d));
    ContactPoint<Scalar> point{.n = (distance > 0 ? Scalar{1} / distance : Scalar{0}) * d,
                               .overlap = bodies.radius[i] + bodies.radius[j] - distance,
                               .arm = Scalar{1},
                               .v = difference(work_.slots.velocity),
                               .u = {},
                               .w = bodies.inverse_mass[i] + bodies.inverse_mass[j],
                               .rho = bodies.inverse_radius[i] + bodies.inverse_radius[j]};
    return {point, distance, numbers_in<Scalar>(materials_(bodies.type_of(i), bodies.type_of(j)))};
  }

  /// Fills the slots; finds the pairs anew where bodies, box or positions have changed too much.
  void prepare(const auto& y, const Memory& memory, bool rolls, const ActiveSet* active) const {
    const auto& body = y.body;
    const auto& pairs = [&]() -> const Pairs& { return *memory.places->pairs; };
    bool serves = memory.places != nullptr && (active != nullptr || memory.places->strays.empty());
    if (serves && memory.body != body.serial) {
      serves = pairs().bodies.are(body) && pairs().period == domain_of(body.box).length;
      if (serves) materials_.check_types(body), memory.adopt(body.serial, rolls, tables_);
    }
    serves = serves && pairs().bodies.size() == static_cast<std::size_t>(y.r.cols());
    if (serves && gather(y, *memory.places, active)) return;
    if (!serves || active == nullptr || !find_late(y, memory)) find_pairs(y, memory, rolls);
    static_cast<void>(gather(y, *memory.places, active));
  }
  [[nodiscard]] bool gather(const auto& y, const Places& places, const ActiveSet* active) const {
    if (active != nullptr) work_.computed.update(places, *active);
    return work_.slots.gather(y, places, active != nullptr ? &work_.computed : nullptr);
  }
  /// The pairs of those that have moved, where these are few.
  [[nodiscard]] bool find_late(const auto& y, const Memory& memory) const {
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    auto places = places_.take();
    *places = *memory.places;
    if (!std::get<ContactSearch<Scalar, dim>>(work_.late).find_late(y.r, y.body, work_.slots.moved(), *places))
      return false;
    ++statistics_.late;
    memory.places = std::move(places);
    return true;
  }
  void find_pairs(const auto& y, const Memory& memory, bool rolls) const {
    const auto& body = y.body;
    check_bodies(body, y.r.cols());
    materials_.check_types(body);
    ++statistics_.rebuilds;
    auto pairs = std::make_shared<Pairs>();
    Scalar skin = static_cast<Scalar>(skin_);
    if (skin == Scalar{0} && y.r.cols() > 0) skin = static_cast<Scalar>(0.6) * body.radius.mean();
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    // Searches are rare: between them their memory would outweigh the state.
    tables_.forget();
    ContactSearch<Scalar, dim>{}.find(y.r, body, skin, *pairs);
    memory.move_to(std::make_shared<Places>(Places{std::move(pairs)}), body.serial, rolls, tables_);
  }

  template <bool spins, bool rolls>
  void add_up(const Places& places, const Springs& before, Springs& after, Scalar elapsed, auto& numbers) const {
    const auto nearest = nearest_image<P>(places.pairs->period);
    std::size_t count = after.size();  // but for the late ones
    while (!places.late.empty() && count > 0 && !places.pairs->has(after.place[count - 1])) --count;
    work_.sums.template add_up<spins, rolls>(work_.touching, count, after.size(), [&](std::size_t c) {
      return work_.touching.template force<spins, rolls, Law>(work_.slots, work_.sums, nearest, before, after, elapsed,
                                                              numbers, c);
    });
  }

  Materials<Law> materials_;
  double skin_;
  mutable Scratch<Workspace> work_;
  mutable RecycledSprings<Springs> tables_;
  mutable Recycled<Places> places_;
  mutable ContactStatistics statistics_;
};
template <class Law>
Contact(const Law&, double = 0) -> Contact<Law>;

}}  // namespace phistep::PHISTEP_ABI
