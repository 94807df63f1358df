/// @file
/// The passes over bodies and pairs that a force of contacts is made of:
///
///   gather    bodies into slots in cache order (contact_slots.hpp); the pairs are found anew where one moved too far
///   touch     which pairs touch (touching_pairs.hpp)
///   compute   the law (contact_kernel.hpp) for those, a pack at a time, and its sum on each slot (slot_sums.hpp)
///   give      from the slots to the user's order
///
/// Each pair is computed once.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/scratch.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/computed_pairs.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/contact_law.hpp"
#include "phistep/particles/contacts/contact_memory.hpp"
#include "phistep/particles/contacts/contact_pairs.hpp"
#include "phistep/particles/contacts/contact_search.hpp"
#include "phistep/particles/contacts/contact_slots.hpp"
#include "phistep/particles/contacts/slot_sums.hpp"
#include "phistep/particles/contacts/spring_table.hpp"
#include "phistep/particles/contacts/touching_pairs.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The work of a force of contacts so far.
struct ContactStatistics {
  std::int64_t evaluations = 0;  ///< passes over the pairs
  std::int64_t rebuilds = 0;     ///< times the pairs were found anew
  std::int64_t pairs = 0;        ///< tested at the last evaluation
  std::int64_t touching = 0;     ///< of them, in contact
};

template <class Law, class Scalar>
class ContactPasses {
 public:
  using Pairs = ContactPairs<Scalar>;
  using Springs = SpringTable<Scalar>;
  using Memory = ContactMemory<Scalar, Pairs>;

  /// @param skin  [length], 0: a fraction of the radii
  ContactPasses(Materials<Law> materials, double skin) : materials_{std::move(materials)}, skin_{skin} {}
  [[nodiscard]] const ContactStatistics& statistics() const { return statistics_; }
  [[nodiscard]] const Materials<Law>& materials() const { return materials_; }

  /// Springs at (t, y); forces and torques lie in the workspace.
  /// @param active  those that are computed, with all that acts on them; null: all
  template <class View>
  std::shared_ptr<Springs> evaluate(Scalar t, const View& y, const Memory& memory, const ActiveSet* active) const {
    constexpr bool spins = requires { y.omega; };
    const bool rolls = spins && materials_.rolls();
    prepare(y, memory, rolls, active);
    const Pairs& pairs = *memory.places;
    const PairRange range = work_.computed.of(pairs, active);
    memory.part(
        number_of(active), [this](std::int32_t place) { return work_.computed.has_pair(place); }, tables_,
        work_.computed.before(), work_.computed.joined());
    std::shared_ptr<Springs> springs = tables_.take();
    ++statistics_.evaluations;
    work_.touching.find(pairs.period, range, work_.slots, *memory.springs, *springs, rolls);
    work_.sums.clear(pairs.bodies.size(), active ? &work_.computed.slots() : nullptr, rolls);
    statistics_.pairs = static_cast<std::int64_t>(range.count);
    statistics_.touching = static_cast<std::int64_t>(springs->size());
    const auto compute = [&](auto&& numbers) {
      if (rolls) add_up<spins, spins>(pairs, *memory.springs, *springs, memory.elapsed(t), numbers);
      else add_up<spins, false>(pairs, *memory.springs, *springs, memory.elapsed(t), numbers);
    };
    if (materials_.types() == 0) {
      const ContactNumbers<P> all = broadcast_numbers<P>(materials_(0, 0));
      compute([&](const auto&...) { return all; });
    } else {
      compute([&](const std::int32_t* i, const std::int32_t* j) { return lookup(pairs, i, j); });
    }
    springs->close();
    return springs;
  }
  /// From slots to the user's order.
  template <class View>
  void give(const View& y, auto& out, const Pairs& pairs) const {
    work_.sums.give(y, pairs.bodies, out, active_set(y));
  }

  /// Σ of the energies stored in the springs.
  [[nodiscard]] Scalar energy(const Pairs& pairs, const Springs& springs) const {
    Scalar sum{0};
    for (std::size_t c = 0; c < springs.size(); ++c) {
      const Meeting at = meet(pairs, static_cast<std::size_t>(springs.place[c]));
      sum += stored_energy<Law, Scalar>(at.numbers, at.overlap, at.rho, {springs.slip[c], springs.roll[c]});
    }
    return sum;
  }

  /// f(i, j, n, K, C) for all pairs, with the users' indices and n from j to i; K and C are 0 where they don't touch.
  void for_each_tangent(const Pairs& pairs, const Springs& springs, Scalar elapsed, auto&& f) const {
    std::size_t c = 0;
    for (std::size_t p = 0; p < pairs.places(); ++p) {
      const Meeting at = meet(pairs, p);
      PairTangent<Scalar> K, C;
      if (c < springs.size() && static_cast<std::size_t>(springs.place[c]) == p) {
        const Triple<Scalar> v = difference(work_.slots.velocity, at.i, at.j);
        contact_tangent<Law>(at.numbers, at.n, at.overlap, at.distance, v, springs.slip[c],
                             work_.slots.surface[4 * at.i + 3] + work_.slots.surface[4 * at.j + 3], at.rho, elapsed, K,
                             C);
        ++c;
      }
      const Scalar n[3] = {at.n.x, at.n.y, at.n.z};
      f(pairs.bodies.particle[at.i], pairs.bodies.particle[at.j], n, K, C);
    }
  }

 private:
  using P = Pack<Scalar, native_width<Scalar>>;

  /// Two bodies of the last evaluation.
  struct Meeting {
    std::size_t i, j;  ///< slots
    Triple<Scalar> n;
    Scalar distance, overlap, rho;
    ContactNumbers<Scalar> numbers;
  };
  [[nodiscard]] static Triple<Scalar> difference(const std::vector<Scalar>& x, std::size_t i, std::size_t j) {
    return {x[4 * i] - x[4 * j], x[4 * i + 1] - x[4 * j + 1], x[4 * i + 2] - x[4 * j + 2]};
  }
  [[nodiscard]] Meeting meet(const Pairs& pairs, std::size_t p) const {
    const auto i = static_cast<std::size_t>(pairs.first[p]), j = static_cast<std::size_t>(pairs.second[p]);
    const auto& bodies = pairs.bodies;
    const Triple<Scalar> d = NearestImage<Scalar>{pairs.period}(difference(work_.slots.position, i, j));
    const Scalar distance = std::sqrt(dot(d, d));
    return {i,
            j,
            (distance > 0 ? Scalar{1} / distance : Scalar{0}) * d,
            distance,
            bodies.radius[i] + bodies.radius[j] - distance,
            bodies.inverse_radius[i] + bodies.inverse_radius[j],
            broadcast_numbers<Scalar>(materials_(bodies.type_of(i), bodies.type_of(j)))};
  }

  struct Workspace {
    ContactSlots<Scalar> slots;
    TouchingPairs<Scalar> touching;
    SlotSums<Scalar> sums;
    ComputedPairs computed;
  };

  /// Fills the slots, and finds the pairs anew where they don't serve.
  template <class View>
  void prepare(const View& y, const Memory& memory, bool rolls, const ActiveSet* active) const {
    const auto& body = y.body;
    bool serves = memory.places != nullptr;
    if (serves && memory.body != body.serial) {
      serves = memory.places->bodies.are(body) && same_box(*memory.places, body.box);
      if (serves) {
        materials_.check_types(body);
        memory.adopt(body.serial, rolls, tables_);
      }
    }
    serves = serves && memory.places->bodies.size() == static_cast<std::size_t>(y.r.cols()) &&
             gather(y, *memory.places, active);
    if (serves) return;
    find_pairs(y, memory, rolls);
    static_cast<void>(gather(y, *memory.places, active));
  }
  [[nodiscard]] bool gather(const auto& y, const Pairs& pairs, const ActiveSet* active) const {
    if (active == nullptr) return work_.slots.gather(y, pairs, nullptr, nullptr);
    work_.computed.update(pairs, *active);
    return work_.slots.gather(y, pairs, &work_.computed, &left_out(y));
  }
  template <class View>
  void find_pairs(const View& y, const Memory& memory, bool rolls) const {
    const auto& body = y.body;
    check_bodies(body, y.r.cols());
    materials_.check_types(body);
    ++statistics_.rebuilds;
    memory.join(tables_);
    // Searches are rare: between them their memory would outweigh the state.
    tables_.forget();
    auto pairs = std::make_shared<Pairs>();
    Scalar skin = static_cast<Scalar>(skin_);
    if (skin == Scalar{0} && y.r.cols() > 0) skin = static_cast<Scalar>(0.6) * body.radius.mean();
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    ContactSearch<Scalar, dim>{}.find(y.r, body, skin, *pairs);
    auto springs = tables_.take();
    if (memory.places) {
      const bool same_bodies = memory.body == body.serial;
      carry_springs(*memory.places, *memory.springs, *pairs, *springs, rolls, same_bodies, memory.dormant);
    } else {
      springs->resize(0, rolls);
      springs->close();
    }
    memory.places = std::move(pairs);
    memory.springs = std::move(springs);
    memory.body = body.serial;
  }
  [[nodiscard]] static bool same_box(const Pairs& pairs, const auto& box) {
    for (std::size_t a = 0; a < box.is_periodic.size(); ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      const Scalar period = box.is_periodic[a] ? box.upper[axis] - box.lower[axis] : Scalar{0};
      if (pairs.period[a] != period) return false;
    }
    return true;
  }

  template <bool spins, bool rolls>
  void add_up(const Pairs& pairs, const Springs& before, Springs& after, Scalar elapsed, auto& numbers) const {
    const NearestImage<P> nearest{pairs.period};
    work_.sums.template add_up<spins, rolls>(work_.touching, after.size(), [&](std::size_t c) {
      return force_of<spins, rolls>(nearest, before, after, elapsed, numbers, c);
    });
  }
  /// The force of the contacts c, c + 1, …
  template <bool spins, bool rolls>
  [[nodiscard]] ContactForce<P> force_of(const NearestImage<P>& nearest, const Springs& before, Springs& after,
                                         Scalar elapsed, auto& numbers, std::size_t c) const {
    constexpr std::size_t width = P::width;
    const auto& slots = work_.slots;
    const std::int32_t *const i = &work_.touching.i[c], *const j = &work_.touching.j[c];
    if (c + 3 * width <= after.size())
      for (std::size_t l = 2 * width; l < 3 * width; ++l) {
        prefetch(&slots.velocity[4 * static_cast<std::size_t>(j[l])]);
        prefetch(&slots.surface[4 * static_cast<std::size_t>(j[l])]);
        work_.sums.prefetch_slot(j[l]);
      }
    const auto ri = gather4<P>(slots.position.data(), i), rj = gather4<P>(slots.position.data(), j);
    const auto vi = gather4<P>(slots.velocity.data(), i), vj = gather4<P>(slots.velocity.data(), j);
    const auto ui = gather4<P>(slots.surface.data(), i), uj = gather4<P>(slots.surface.data(), j);
    const Triple<P> d = nearest({ri.x - rj.x, ri.y - rj.y, ri.z - rj.z});
    const P distance = sqrt(dot(d, d)), reach = ri.w + rj.w;
    // Two centres in one point have no direction: NaN, which the step reports.
    ContactPoint<P> at{(P(1) / distance) * d,
                       reach - distance,
                       has_full_arms<Law> ? P(1) : distance / reach,
                       {vi.x - vj.x, vi.y - vj.y, vi.z - vj.z},
                       {ui.x + uj.x, ui.y + uj.y, ui.z + uj.z},
                       ui.w + uj.w,
                       vi.w + vj.w};
    if constexpr (rolls) at.turning = {vi.w * ui.x - vj.w * uj.x, vi.w * ui.y - vj.w * uj.y, vi.w * ui.z - vj.w * uj.z};
    return contact_force<spins, rolls, Law>(numbers(i, j), at, elapsed, before, &work_.touching.from[c], after, c);
  }
  [[nodiscard]] ContactNumbers<P> lookup(const Pairs& pairs, const std::int32_t* i, const std::int32_t* j) const {
    const ContactNumbers<double>* of[P::width];
    for (int l = 0; l < P::width; ++l)
      of[l] = &materials_(pairs.bodies.type_of(static_cast<std::size_t>(i[l])),
                          pairs.bodies.type_of(static_cast<std::size_t>(j[l])));
    return lane_numbers<P>(of);
  }

  Materials<Law> materials_;
  double skin_;
  mutable Scratch<Workspace> work_;
  mutable RecycledSprings<Springs> tables_;
  mutable ContactStatistics statistics_;
};

}}  // namespace phistep::PHISTEP_ABI
