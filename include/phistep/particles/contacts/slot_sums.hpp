/// @file
/// The sums of contacts' forces on each body, by slots, and back into the user's order. A body's forces add up in the order
/// of its pairs, whatever the number of threads.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "phistep/base/machine/shares.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/contact_kernel.hpp"
#include "phistep/particles/contacts/contact_slots.hpp"
#include "phistep/particles/contacts/touching_pairs.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// A workspace, its buffers serve again.
template <class Scalar>
class SlotSums {
  using P = Pack<Scalar, native_width<Scalar>>;
  /// On a slot: in one cache line (where they are double).
  struct alignas(8 * sizeof(Scalar)) Sum {
    Scalar force[4], twist[4];
  };
  /// Of one contact.
  struct Effect {
    Scalar force[3], twist[3], torque[3];
  };

 public:
  /// Before add_up: the sums of some slots are 0, those of the others of no interest; null: of all.
  void clear(std::size_t n, const std::vector<std::int32_t>* slots, bool rolls) {
    if (slots == nullptr) {
      sum_.resize(n);
      const auto clear_part = [this](std::ptrdiff_t begin, std::ptrdiff_t end) {
        std::fill(sum_.begin() + begin, sum_.begin() + end, Sum{});
      };
      for_each_range(static_cast<std::ptrdiff_t>(n), 1, clear_part, shared_from / 8);
      torque_.assign(rolls ? 4 * n : 0, Scalar{0});
      return;
    }
    sum_.resize(n);
    torque_.resize(rolls ? 4 * n : 0);
    for (const std::int32_t slot : *slots) {
      const auto s = static_cast<std::size_t>(slot);
      sum_[s] = Sum{};
      if (rolls) std::fill_n(torque_.begin() + static_cast<std::ptrdiff_t>(4 * s), 4, Scalar{0});
    }
  }
  /// @param force_of  c ↦ ContactForce of the contacts c, c + 1, … of a pack
  template <bool spins, bool rolls>
  void add_up(const TouchingPairs<Scalar>& contacts, std::size_t count, auto&& force_of) {
    const std::int32_t *const i = contacts.i.data(), *const j = contacts.j.data();
    // A thread adds up on the bodies that its contacts have first, up to the next thread's first. What its contacts do to
    // others is kept: these must come before the others' own.
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
  }
  void prefetch_slot(std::int32_t slot) const { prefetch(&sum_[static_cast<std::size_t>(slot)]); }

  /// Adds the sums to the user's forces and torques.
  /// @param active  on these; null: on all
  template <class View>
  void give(const View& y, const ContactBodies<Scalar>& bodies, auto& out, const ActiveSet* active) const {
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    constexpr std::size_t ahead = ContactSlots<Scalar>::ahead;
    const bool turned = !torque_.empty();
    const std::int32_t* const list = active == nullptr ? nullptr : active->list().data();
    const std::size_t n = active == nullptr ? bodies.size() : active->list().size();
    const auto body = [list](std::size_t k) { return list == nullptr ? k : static_cast<std::size_t>(list[k]); };
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = body(k);
      const auto s = static_cast<std::size_t>(bodies.slot[i]);
      const auto column = static_cast<Eigen::Index>(i);
      if (k + ahead < n) prefetch_slot(bodies.slot[body(k + ahead)]);
      const Sum& of = sum_[s];
      // x − x: 0, or NaN for a body whose place is not a number, which touches nothing
      for (int a = 0; a < dim; ++a) out.force(a, column) += of.force[a] + (y.r(a, column) - y.r(a, column));
      if constexpr (requires { y.omega; }) {
        const Scalar radius = y.body.radius[column];
        const auto torque = [&](int a) {
          return radius * of.twist[a] + (turned ? torque_[4 * s + static_cast<std::size_t>(a)] : Scalar{0});
        };
        if constexpr (dim == 3)
          for (int a = 0; a < 3; ++a) out.torque(a, column) += torque(a);
        else out.torque(0, column) += torque(2);
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
