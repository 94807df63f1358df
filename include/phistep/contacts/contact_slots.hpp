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

#include "phistep/contacts/computed_pairs.hpp"
#include "phistep/contacts/contact_pairs.hpp"
#include "phistep/core/version.hpp"
#include "phistep/neighbors/places.hpp"

namespace phistep::inline PHISTEP_ABI {

/// Four numbers of each slot in each array. A workspace, its buffers serve again.
template <class Scalar>
struct ContactSlots {
  /// Users' orders may be random: what comes so many bodies later is fetched in time.
  static constexpr std::size_t ahead = 16;

  std::vector<Scalar> position;  ///< x, y, z, R
  std::vector<Scalar> velocity;  ///< v, 1/R
  std::vector<Scalar> surface;   ///< R ω, 1/m

  /// False: a body has moved by half the skin since the pairs were found.
  /// @param computed  fills the slots of these pairs alone, and looks at bodies held elsewhere: no other moves; null: all
  template <class View>
  [[nodiscard]] bool gather(const View& y, const ContactPairs<Scalar>& pairs, const ComputedPairs* computed) {
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
    if (computed != nullptr)
      for (const std::int32_t slot : computed->held()) {
        const auto s = static_cast<std::size_t>(slot);
        largest = std::max(largest, square_moved(y, pairs, s));
      }
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
      const Scalar d = y.r(a, i) - pairs.built_at[4 * s + static_cast<std::size_t>(a)];
      moved += d * d;
    }
    return moved;
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
    const Scalar* const from = &pairs.built_at[4 * s];
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
};

}  // namespace phistep::inline PHISTEP_ABI
