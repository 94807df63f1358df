/// @file
/// Bodies in slots, in cache order: the numbers of each that its contacts need side by side.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/state/active_set.hpp"
#include "phistep/base/version.hpp"
#include "phistep/particles/contacts/computed_pairs.hpp"
#include "phistep/particles/contacts/contact_pairs.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Four numbers of each slot in each array. A workspace, its buffers serve again.
template <class Scalar>
struct ContactSlots {
  /// Users' orders may be random: what comes so many bodies later is fetched in time.
  static constexpr std::size_t ahead = 16;

  std::vector<Scalar> position;  ///< x, y, z, R
  std::vector<Scalar> velocity;  ///< v, 1/R
  std::vector<Scalar> surface;   ///< R ω, 1/m

  /// False: a body has moved by half the skin since the pairs were found.
  /// @param computed  only the slots of these pairs are filled; null: all are
  /// @param left_out  what is known of the other bodies (base/state/active_set.hpp); of no interest where all slots are filled
  template <class View>
  [[nodiscard]] bool gather(const View& y, const ContactPairs<Scalar>& pairs, const ComputedPairs* computed,
                            const LeftOut* left_out) {
    const std::size_t n = pairs.bodies.size();
    position.resize(4 * n), velocity.resize(4 * n), surface.resize(4 * n);
    const std::int32_t* const list = computed == nullptr ? nullptr : computed->slots().data();
    const std::size_t count = computed == nullptr ? n : computed->slots().size();
    Scalar largest = 0;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) reduction(max : largest)
#endif
    for (std::size_t k = 0; k < count; ++k) {
      const auto slot_of = [list](std::size_t p) { return list == nullptr ? p : static_cast<std::size_t>(list[p]); };
      if (k + ahead < count) fetch(y, pairs.bodies.particle[slot_of(k + ahead)]);
      const Scalar moved = fill(y, pairs, slot_of(k));
      largest = largest < moved ? moved : largest;  // a NaN touches nothing; its force becomes NaN
    }
    if (computed != nullptr) largest = std::max(largest, largest_elsewhere(y, pairs, *computed, *left_out));
    return 4 * largest <= pairs.skin * pairs.skin;
  }

 private:
  template <class View>
  static constexpr int dim_of = std::remove_cvref_t<decltype(std::declval<View>().r)>::RowsAtCompileTime;

  template <class View>
  static void fetch(const View& y, Eigen::Index next) {
    prefetch(y.r.data() + dim_of<View> * next);
    prefetch(y.v.data() + dim_of<View> * next);
    if constexpr (requires { y.omega; }) prefetch(y.omega.data() + y.omega.rows() * next);
  }
  template <class View>
  [[nodiscard]] static Scalar square_moved(const View& y, const ContactPairs<Scalar>& pairs, std::size_t s) {
    const Eigen::Index i = pairs.bodies.particle[s];
    Scalar moved = 0;
    for (int a = 0; a < dim_of<View>; ++a) {
      const Scalar d = y.r(a, i) - pairs.built_at[3 * s + static_cast<std::size_t>(a)];
      moved += d * d;
    }
    return moved;
  }
  /// The largest square of what a body has moved that isn't in those slots: all are looked at once for a list and a number
  /// of what is left out, then those that move, and those that no longer are in the slots.
  template <class View>
  [[nodiscard]] Scalar largest_elsewhere(const View& y, const ContactPairs<Scalar>& pairs,
                                         const ComputedPairs& computed, const LeftOut& left_out) {
    Scalar largest = 0;
    const auto look = [&](std::size_t s) { largest = std::max(largest, square_moved(y, pairs, s)); };
    if (left_out.number == 0 || left_out.number != seen_left_out_ || pairs.number != seen_pairs_) {
      for (std::size_t s = 0; s < pairs.bodies.size(); ++s)
        if (!computed.has_slot(s)) look(s);
      seen_left_out_ = left_out.number, seen_pairs_ = pairs.number;
    } else {
      for (const std::int32_t i : left_out.moving)
        look(static_cast<std::size_t>(pairs.bodies.slot[static_cast<std::size_t>(i)]));
      for (const std::int32_t slot : computed.dropped()) look(static_cast<std::size_t>(slot));
    }
    return largest;
  }
  /// How far it has moved, squared.
  template <class View>
  [[nodiscard, gnu::always_inline]] inline Scalar fill(const View& y, const ContactPairs<Scalar>& pairs,
                                                       std::size_t s) {
    constexpr int dim = dim_of<View>;
    const Eigen::Index i = pairs.bodies.particle[s];
    const Scalar radius = pairs.bodies.radius[s];
    Scalar* const x = &position[4 * s];
    Scalar* const v = &velocity[4 * s];
    Scalar* const u = &surface[4 * s];
    const Scalar* const from = &pairs.built_at[3 * s];
    x[2] = v[2] = u[0] = u[1] = u[2] = 0;
    Scalar moved = 0;
    for (int a = 0; a < dim; ++a) {
      x[a] = y.r(a, i);
      v[a] = y.v(a, i);
      moved += (x[a] - from[a]) * (x[a] - from[a]);
    }
    if constexpr (requires { y.omega; }) {
      if constexpr (dim == 3)
        for (int a = 0; a < 3; ++a) u[a] = radius * y.omega(a, i);
      else u[2] = radius * y.omega(0, i);
    }
    x[3] = radius;
    v[3] = pairs.bodies.inverse_radius[s];
    u[3] = pairs.bodies.inverse_mass[s];
    return moved;
  }

  std::uint64_t seen_left_out_ = 0, seen_pairs_ = 0;  // the last ones for which all others were looked at
};

}}  // namespace phistep::PHISTEP_ABI
