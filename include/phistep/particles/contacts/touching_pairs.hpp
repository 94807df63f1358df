/// @file
/// The pairs that touch, by positions alone, and the sums of their forces on each body.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/contact_pairs.hpp"
#include "phistep/particles/contacts/contact_slots.hpp"
#include "phistep/particles/contacts/spring_table.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// The work of a force of contacts so far.
struct ContactStatistics {
  std::int64_t evaluations = 0;  ///< passes over the pairs
  std::int64_t rebuilds = 0;     ///< times the pairs were found anew
  std::int64_t late = 0;         ///< times those of few bodies were
  std::int64_t pairs = 0;        ///< tested at the last evaluation
  std::int64_t touching = 0;     ///< of them, in contact
};

/// The pairs that touch. A workspace, its buffers serve again.
template <class Scalar>
class TouchingPairs {
  static constexpr int width = native_width<Scalar>;
  using P = Pack<Scalar, width>;

 public:
  std::vector<std::int32_t> from;  ///< of each contact, where its springs stand in the table before
  std::vector<std::int32_t> i, j;  ///< and its slots

  /// Fills the table with the contacts' places, and makes room for their springs.
  /// @param period  of the box, as in ContactPairs
  void find(const std::array<double, 3>& period, const PairRange& pairs, const ContactSlots<Scalar>& slots,
            const auto& before, auto& table, bool with_roll) {
    const auto nearest = nearest_image<P>(period);
    if (i.size() < pairs.count + width) resize_with_spare(i, pairs.count + width);
    found_.assign(thread_count(), {});
    // Threads write the numbers of those that touch into i, from where their own pairs begin; then the gaps are closed.
    for_each_share(pairs.count, width, shared_from / 64, [&](const Share& own) {
      found_[own.number] = {own.begin, find(nearest, pairs, slots, own.begin, own.end)};
    });
    std::size_t found = 0;
    for (const auto& [begin, end] : found_) {
      if (begin != found) std::copy(i.data() + begin, i.data() + end, i.data() + found);
      found += end - begin;
    }
    table.resize(found, with_roll);
    for (auto* array : {&from, &j}) resize_with_spare(*array, found + width);
    for_each_share(found, 1, shared_from / 64, [&](const Share& own) {
      if (own.begin == own.end) return;
      auto springs_of = spring_finder(before.place, pairs.number(static_cast<std::size_t>(i[own.begin])));
      for (std::size_t c = own.begin; c < own.end; ++c) {
        const auto p = static_cast<std::size_t>(i[c]);
        table.place[c] = pairs.number(p);
        from[c] = springs_of(table.place[c]);
        i[c] = pairs.first[p];
        j[c] = pairs.second[p];
      }
    });
    // Whole packs: those beyond the last contact repeat its slots, and find springs that are unstretched.
    std::fill_n(from.begin() + static_cast<std::ptrdiff_t>(found), width, static_cast<std::int32_t>(before.size()));
    for (auto* array : {&i, &j})
      std::fill_n(array->begin() + static_cast<std::ptrdiff_t>(found), width, found > 0 ? (*array)[found - 1] : 0);
  }

  /// The force of the contacts c, c + 1, …
  /// @param numbers  (slots, slots) ↦ the laws' numbers
  template <bool spins, bool rolls, class Law>
  [[nodiscard]] ContactForce<P> force(const ContactSlots<Scalar>& slots, const auto& sums, const auto& nearest,
                                      const auto& before, auto& after, Scalar elapsed, auto& numbers,
                                      std::size_t c) const {
    constexpr std::size_t pack = P::width;
    const std::int32_t *const first = &i[c], *const second = &j[c];
    if (c + 3 * pack <= after.size())
      for (std::size_t l = 2 * pack; l < 3 * pack; ++l) {
        prefetch(&slots.velocity[4 * static_cast<std::size_t>(second[l])]);
        prefetch(&slots.surface[4 * static_cast<std::size_t>(second[l])]);
        sums.prefetch_slot(second[l]);
      }
    const auto ri = gather4<P>(slots.position.data(), first), rj = gather4<P>(slots.position.data(), second);
    const auto vi = gather4<P>(slots.velocity.data(), first), vj = gather4<P>(slots.velocity.data(), second);
    const auto ui = gather4<P>(slots.surface.data(), first), uj = gather4<P>(slots.surface.data(), second);
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
    auto springs = before.template load<rolls, P>(&from[c]);
    const auto out = contact_force<spins, rolls, Law>(numbers(first, second), at, P(elapsed), springs);
    after.template store<rolls>(springs, c);
    return out;
  }

 private:
  /// Among the pairs begin … end − 1; returns where those end that are written from `begin` on.
  [[gnu::flatten]] std::size_t find(const auto& nearest, const PairRange& pairs, const ContactSlots<Scalar>& slots,
                                    std::size_t begin, std::size_t end) {
    const Scalar* const position = slots.position.data();
    std::int32_t* to = i.data() + begin;
    for (std::size_t p = begin; p < end; p += width) {
      const auto a = gather4<P>(position, &pairs.first[p]);
      const auto b = gather4<P>(position, &pairs.second[p]);
      const Triple<P> d = nearest({a.x - b.x, a.y - b.y, a.z - b.z});
      const P reach = a.w + b.w;
      unsigned touching = (dot(d, d) < reach * reach).bits();
      if (end - p < width) touching &= (1u << (end - p)) - 1u;
      for (; touching != 0; touching &= touching - 1)
        *to++ = static_cast<std::int32_t>(p + static_cast<std::size_t>(std::countr_zero(touching)));
    }
    return static_cast<std::size_t>(to - i.data());
  }

  std::vector<std::array<std::size_t, 2>> found_;  // contacts, by each thread: from, and to one before
};

/// The sums of contacts' forces on each body, in slots, and their way into the user's order. A body's forces add up in the order of its
/// pairs, whatever the number of threads. A workspace.
template <class Scalar>
class SlotSums {
  using P = Pack<Scalar, native_width<Scalar>>;
  /// On a slot: in one cache line (where they are double).
  struct alignas(8 * sizeof(Scalar)) Sum {
    Scalar force[4], twist[4];
  };
  /// Forces and torques of one contact.
  struct Effect {
    Scalar force[3], twist[3], torque[3];
  };

 public:
  /// Before add_up: sets the sums of some slots to 0; null: of all.
  void clear(std::size_t n, const std::vector<std::int32_t>* slots, bool rolls) {
    sum_.resize(n);
    torque_.resize(rolls ? 4 * n : 0);
    const auto clear_some = [&, some = slots ? slots->data() : nullptr](std::ptrdiff_t begin, std::ptrdiff_t end) {
      for (std::ptrdiff_t k = begin; k < end; ++k) {
        const std::ptrdiff_t s = some ? some[k] : k;
        sum_[static_cast<std::size_t>(s)] = Sum{};
        if (rolls) std::fill_n(torque_.begin() + 4 * s, 4, Scalar{0});
      }
    };
    for_each_range(static_cast<std::ptrdiff_t>(slots ? slots->size() : n), 1, clear_some, shared_from / 8);
  }
  /// @param count     of contacts ascending by their slots; others follow, up to `last`
  /// @param force_of  c ↦ ContactForce of the contacts c, c + 1, … of a pack
  template <bool spins, bool rolls>
  void add_up(const TouchingPairs<Scalar>& contacts, std::size_t count, std::size_t last, auto&& force_of) {
    const std::int32_t *const i = contacts.i.data(), *const j = contacts.j.data();
    // A thread sums for the bodies from its first contact's first one to the next thread's. Effects of its contacts on other bodies are
    // kept: they must be added before the others' own.
    constexpr std::int32_t beyond = std::numeric_limits<std::int32_t>::max();
    const auto first_slot = [&](std::size_t c) { return c == 0 ? 0 : c < count ? i[c] : beyond; };
    kept_.assign(thread_count(), {});
    const auto by_threads = [&](auto&& part) { for_each_share(count, P::width, shared_from / 64, part); };
    by_threads([&](const Share& own) {
      const std::int32_t high = first_slot(own.end);
      std::size_t c = high == beyond ? own.end : own.begin;
      while (c < own.end && i[c] < high && j[c] < high) ++c;
      if (c < own.end) c -= (c - own.begin) % P::width;
      kept_[own.number] = {c, own.end, 0};
    });
    std::size_t all = 0;
    for (Kept& kept : kept_) kept.at = all, all += kept.end - kept.begin;
    effects_.resize(all);
    by_threads([&](const Share& own) {
      const Kept& kept = kept_[own.number];
      compute<spins, rolls>(contacts, kept.begin, kept.end, force_of, &kept);
    });
    by_threads([&](const Share& own) {
      const std::int32_t low = first_slot(own.begin), high = first_slot(own.end);
      const auto put_kept = [&](const Kept& kept) {
        for (std::size_t c = kept.begin; c < kept.end; ++c) {
          if (i[c] >= low && i[c] < high) put<rolls>(effect_of(kept, c), 1, static_cast<std::size_t>(i[c]));
          if (j[c] >= low && j[c] < high) put<rolls>(effect_of(kept, c), -1, static_cast<std::size_t>(j[c]));
        }
      };
      for (std::size_t t = 0; t < own.number; ++t) put_kept(kept_[t]);
      compute<spins, rolls>(contacts, own.begin, kept_[own.number].begin, force_of, nullptr);
      put_kept(kept_[own.number]);
    });
    compute<spins, rolls>(contacts, count, last, force_of, nullptr);
  }
  void prefetch_slot(std::int32_t slot) const { prefetch(&sum_[static_cast<std::size_t>(slot)]); }

  /// Adds the sums to the user's forces and torques.
  /// @param active  on these; null: on all
  void give(const auto& y, const ContactBodies<Scalar>& bodies, auto& out, const ActiveSet* active) const {
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    constexpr std::size_t ahead = ContactSlots<Scalar>::ahead;
    const bool turned = !torque_.empty();
    const std::int32_t* const list = active == nullptr ? nullptr : active->list().data();
    const std::size_t n = active == nullptr ? bodies.size() : active->list().size();
    const auto body = [list](std::size_t k) { return list == nullptr ? k : static_cast<std::size_t>(list[k]); };
    PHISTEP_DETAIL_OMP("omp parallel for schedule(static)")
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = body(k);
      const auto s = static_cast<std::size_t>(bodies.slot[i]);
      const auto column = static_cast<Eigen::Index>(i);
      if (k + ahead < n) prefetch_slot(bodies.slot[body(k + ahead)]);
      const Sum& of = sum_[s];
      // x − x: 0, or NaN for a body whose place is not a number, which touches nothing
      for (int a = 0; a < dim; ++a) out.force(a, column) += of.force[a] + (y.r(a, column) - y.r(a, column));
      if constexpr (HasSpin<decltype(y)>) {
        const Scalar radius = y.body.radius[column];
        for (std::size_t a = dim == 3 ? 0 : 2, first = a; a < 3; ++a)
          out.torque(static_cast<int>(a - first), column) +=
              radius * of.twist[a] + (turned ? torque_[4 * s + a] : Scalar{0});
      }
    }
  }

 private:
  // Contacts of a thread whose effects are kept, and where in effects_.
  struct Kept {
    std::size_t begin = 0, end = 0, at = 0;
  };
  [[nodiscard]] Effect& effect_of(const Kept& kept, std::size_t c) { return effects_[kept.at + c - kept.begin]; }
  /// Keeps the effects of the contacts begin … end − 1, or (null) adds them up.
  template <bool spins, bool rolls>
  [[gnu::flatten]] void compute(const TouchingPairs<Scalar>& contacts, std::size_t begin, std::size_t end,
                                auto&& force_of, const Kept* kept) {
    for (std::size_t c = begin; c < end; c += P::width) {
      const ContactForce<P> force = force_of(c);
      for (std::size_t l = 0; l < P::width && c + l < end; ++l) {
        const Effect its = lane<spins, rolls>(force, l);
        if (kept != nullptr) {
          effect_of(*kept, c + l) = its;
          continue;
        }
        put<rolls>(its, 1, static_cast<std::size_t>(contacts.i[c + l]));
        put<rolls>(its, -1, static_cast<std::size_t>(contacts.j[c + l]));
      }
    }
  }
  template <bool spins, bool rolls>
  [[nodiscard]] static Effect lane(const ContactForce<P>& f, std::size_t l) {
    const int k = static_cast<int>(l);
    Effect out{{f.force.x[k], f.force.y[k], f.force.z[k]}, {}, {}};
    if constexpr (spins) out.twist[0] = f.twist.x[k], out.twist[1] = f.twist.y[k], out.twist[2] = f.twist.z[k];
    if constexpr (rolls) out.torque[0] = f.torque.x[k], out.torque[1] = f.torque.y[k], out.torque[2] = f.torque.z[k];
    return out;
  }
  /// On i with the sign 1, on j with −1.
  template <bool rolls>
  void put(const Effect& effect, Scalar sign, std::size_t slot) {
    Sum& to = sum_[slot];
    for (std::size_t a = 0; a < 3; ++a) to.force[a] += sign * effect.force[a], to.twist[a] += effect.twist[a];
    if constexpr (rolls)
      for (std::size_t a = 0; a < 3; ++a) torque_[4 * slot + a] += sign * effect.torque[a];
  }

  std::vector<Sum> sum_;        // of each slot
  std::vector<Scalar> torque_;  // of rolling, 4 a slot, or none
  std::vector<Kept> kept_;
  std::vector<Effect> effects_;
};

}}  // namespace phistep::PHISTEP_ABI
