/// @file
/// Bodies in slots, in cache order: the numbers of each that its contacts need side by side.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <type_traits>
#include <vector>

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
  template <class View>
  [[nodiscard]] bool gather(const View& y, const ContactPairs<Scalar>& pairs) {
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    const std::size_t n = pairs.bodies.size();
    position.resize(4 * n), velocity.resize(4 * n), surface.resize(4 * n);
    Scalar largest = 0;
#ifdef _OPENMP
#pragma omp parallel for schedule(static) reduction(max : largest)
#endif
    for (std::size_t s = 0; s < n; ++s) {
      const Eigen::Index i = pairs.bodies.particle[s];
      if (s + ahead < n) {
        const Eigen::Index next = pairs.bodies.particle[s + ahead];
        prefetch(y.r.data() + dim * next);
        prefetch(y.v.data() + dim * next);
        if constexpr (requires { y.omega; }) prefetch(y.omega.data() + y.omega.rows() * next);
      }
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
      largest = largest < moved ? moved : largest;  // a NaN touches nothing; its force becomes NaN
      if constexpr (requires { y.omega; }) {
        if constexpr (dim == 3)
          for (int a = 0; a < 3; ++a) u[a] = radius * y.omega(a, i);
        else u[2] = radius * y.omega(0, i);
      }
      x[3] = radius;
      v[3] = pairs.bodies.inverse_radius[s];
      u[3] = pairs.bodies.inverse_mass[s];
    }
    return 4 * largest <= pairs.skin * pairs.skin;
  }
};

}  // namespace phistep::inline PHISTEP_ABI
