/// @file
/// A network of linear springs between particles, with or without dashpots.
///
/// Force on i from the spring (i, j) with d = r_j − r_i, ℓ = |d|, n = d/ℓ:   f = [k (ℓ − L) + c n·(v_j − v_i)] n
/// and its tangent along and across n:  ∂f/∂r_j = B = k n nᵀ + k (1 − L/ℓ) (I − n nᵀ), without the dashpot's part in r.
/// Where ℓ = 0, n is not defined and f = 0, the mean over all n: such a spring pushes again as soon as its ends differ.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/particles/springs/spring_rows.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// One spring.
struct Spring {
  std::ptrdiff_t i, j;  ///< its two particles
  double stiffness;     ///< k [force/length]
  double length;        ///< L at rest [length]
};

/// No dashpots: the force ignores v, and says so by its type.
struct NoDamping {};
/// A dashpot beside every spring: c [force·time/length], along the spring.
struct SpringDamping {
  double c;  ///< [force·time/length]
};

/// Springs between the particles of a motion whose positions are a flat vector (x₀ y₀ [z₀] x₁ …) or a dim×N matrix. To
/// change one, make a new network.
template <int dim, class Damping = NoDamping>
struct SpringNetwork : ForceTerm {
  [[no_unique_address]] Damping damping;

  static constexpr bool damped = std::is_same_v<Damping, SpringDamping>;
  static constexpr bool uses_velocity = damped, uses_time = false;
  static constexpr Structure structure = Structure::network;
  static constexpr bool has_edges = true, is_symmetric = !damped;
  static constexpr int block = dim;

  /// @throws std::invalid_argument where a spring joins a particle to itself, or has a stiffness or length that is
  /// negative or not finite.
  explicit SpringNetwork(std::vector<Spring> list, Damping d = {}) : damping(d), springs_(std::move(list)) {
    for (const Spring& s : springs_)
      if (s.i == s.j || s.i < 0 || s.j < 0 || std::max(s.i, s.j) == std::numeric_limits<std::ptrdiff_t>::max() ||
          !(s.stiffness >= 0) || !(s.length >= 0) || !std::isfinite(s.stiffness) || !std::isfinite(s.length))
        throw std::invalid_argument("phistep: spring between particles " + std::to_string(s.i) + " and " +
                                    std::to_string(s.j) + ": needs two particles, stiffness >= 0 and length >= 0");
    if constexpr (damped)
      if (!std::isfinite(damping.c)) throw std::invalid_argument("phistep: a spring's damping must be finite");
    for (Spring& s : springs_) {
      if (s.i > s.j) std::swap(s.i, s.j);
      particles_ = std::max(particles_, s.j + 1);
    }
    // Sorted by their particles, springs find r and f in the caches: shuffled ones took five times as long.
    std::stable_sort(springs_.begin(), springs_.end(),
                     [](const Spring& a, const Spring& b) { return std::tie(a.i, a.j) < std::tie(b.i, b.j); });
  }

  void add(auto /*t*/, const auto& y, auto& out) const {
    using Positions = std::remove_cvref_t<decltype(y.r)>;
    static_assert(!Positions::IsRowMajor || Positions::IsVectorAtCompileTime,
                  "phistep: SpringNetwork needs particles as columns of a column-major matrix, or one flat vector");
    using Scalar = typename std::remove_cvref_t<decltype(out.force)>::Scalar;
    const Scalar* const r = y.r.data();
    const Scalar* v = nullptr;
    if constexpr (damped) v = y.v.data();
    Scalar* const f = out.force.data();
    if (particles_ > y.r.size() / dim)
      throw std::invalid_argument("phistep: a spring names particle " + std::to_string(particles_ - 1) +
                                  ", the state has " + std::to_string(y.r.size() / dim));
    // Large networks, row by row. Whether this is one depends on nothing but the network.
    if constexpr (std::same_as<Scalar, double> || std::same_as<Scalar, float>)
      if (auto& rows = std::get<SpringRows<Scalar, dim, damped>>(rows_); rows.suits(springs_.size(), particles_)) {
        if (rows.empty()) rows.build(springs_, particles_);
        const std::uint8_t* still = nullptr;
        if constexpr (HasBody<decltype(y)>)
          if (!y.body.still.empty()) still = y.body.still.data();
        if constexpr (damped) return rows.add(r, v, still, static_cast<Scalar>(damping.c), f);
        else return rows.add(r, v, still, Scalar{0}, f);
      }
    Scalar sum[dim] = {};  // of the springs of one particle, the first of theirs
    std::ptrdiff_t first = 0;
    const auto give = [&] { unrolled<dim>([&](auto a) { f[dim * first + a] += std::exchange(sum[a], Scalar{0}); }); };
    for_each_pull(r, v, [&](const Spring& s, const auto& d, Scalar pull, Scalar) {
      if (s.i != first) give();
      first = s.i;
      unrolled<dim>([&](auto a) {
        const Scalar x = pull * d[a];
        sum[a] += x;
        f[dim * s.j + a] -= x;
      });
    });
    give();
  }
  /// Σ r·f of the springs and dashpots [energy], for the pressure
  [[nodiscard]] auto virial(auto /*t*/, const auto& y) const {
    using Scalar = typename std::remove_cvref_t<decltype(y.r)>::Scalar;
    Scalar sum{0};
    for_each_pull(y.r.data(), y.v.data(),
                  [&sum](const Spring&, const auto&, Scalar pull, Scalar square) { sum -= pull * square; });
    return sum;
  }

  /// Calls f(i, j) with the two particles of each spring; `Sleeping` asks for it.
  void for_each_pair(const auto& /*memory*/, auto&& f) const {
    for (const Spring& s : springs_) f(s.i, s.j);
  }

  [[nodiscard]] static std::int64_t pair_changes() { return 0; }

  /// ½ Σ k (ℓ − L)² [energy]: the springs' part, dashpots store none
  [[nodiscard]] auto energy(auto /*t*/, const auto& y) const {
    using Scalar = typename std::remove_cvref_t<decltype(y.r)>::Scalar;
    Scalar sum{0};
    for (const Spring& s : springs_) {
      Scalar d[dim];
      const Scalar stretch = std::sqrt(span(s, y.r.data(), d)) - static_cast<Scalar>(s.length);
      sum += static_cast<Scalar>(s.stiffness) * stretch * stretch;
    }
    return sum / 2;
  }

  /// Pairs, where the sink takes them: ∂f/∂r_j = B as above, ∂f/∂v_j = c n nᵀ. They leave out what the dashpots add to
  /// ∂f/∂r, of the order of c|v_j − v_i|/ℓ, for it is not symmetric. Newton then converges linearly. Entries are complete.
  void add_jacobian(auto /*t*/, const auto& y, auto& sink) const {
    using Scalar = typename std::remove_cvref_t<decltype(y.r)>::Scalar;
    for (const Spring& s : springs_) {
      Scalar n[dim];
      const Scalar length = std::sqrt(span(s, y.r.data(), n)), k = static_cast<Scalar>(s.stiffness),
                   L = static_cast<Scalar>(s.length);
      const Scalar inverse = length > Scalar{0} ? Scalar{1} / length : Scalar{0};
      for (int a = 0; a < dim; ++a) n[a] *= inverse;
      // Without a direction there is no force, but for L = 0, where it is k d.
      PairTangent<Scalar> K, C;
      if (length > Scalar{0}) K = {k, k * (Scalar{1} - L * inverse)};
      else if (L == Scalar{0}) K = {k, k};
      if constexpr (damped) C.along = length > Scalar{0} ? static_cast<Scalar>(damping.c) : Scalar{0};
      put_pair<dim, damped>(sink, s.i, s.j, n, K, C);
      if constexpr (damped && !requires { sink.edge(s.i, s.j, n, K, C); })
        put_turning(sink, s, y, n, C.along * inverse);
    }
  }

 private:
  /// d = r_j − r_i; returns |d|².
  template <class Scalar>
  [[nodiscard]] static Scalar span(const Spring& s, const Scalar* r, Scalar (&d)[dim]) {
    const Scalar *const from = r + dim * s.i, *const to = r + dim * s.j;
    unrolled<dim>([&](auto a) { d[a] = to[a] - from[a]; });
    Scalar square = d[0] * d[0];
    unrolled<dim - 1>([&](auto a) { square += d[a + 1] * d[a + 1]; });
    return square;
  }
  /// f(spring, d, f/ℓ, ℓ²)
  template <class Scalar>
  [[gnu::always_inline]] inline void for_each_pull(const Scalar* r, [[maybe_unused]] const Scalar* v, auto&& f) const {
    for (const Spring& s : springs_) {
      Scalar d[dim];
      const Scalar square = span(s, r, d), inverse = 1 / std::sqrt(square),
                   kL = static_cast<Scalar>(s.stiffness * s.length);
      Scalar pull = static_cast<Scalar>(s.stiffness) - kL * inverse;
      if constexpr (damped) {
        const Scalar *const from = v + dim * s.i, *const to = v + dim * s.j;
        Scalar along = d[0] * (to[0] - from[0]);
        unrolled<dim - 1>([&](auto a) { along += d[a + 1] * (to[a + 1] - from[a + 1]); });
        pull += static_cast<Scalar>(damping.c) * along * (inverse * inverse);
      }
      // Ends in one point: k d = 0 where L = 0; else no direction: NaN, which the step reports, as of pairs and contacts.
      f(s, d, square + kL <= 0 ? Scalar{0} : pull, square);
    }
  }
  /// The dashpot's part in ∂f/∂r: c/ℓ [n·Δv (I − nnᵀ) + n ((I − nnᵀ) Δv)ᵀ].
  template <class Scalar>
  static void put_turning(auto& sink, const Spring& s, const auto& y, const Scalar* n, Scalar c) {
    Scalar dv[dim], along{0};
    for (int a = 0; a < dim; ++a) dv[a] = y.v.data()[dim * s.j + a] - y.v.data()[dim * s.i + a], along += n[a] * dv[a];
    const auto turning = [&](int a, int b) {
      return c * (along * (Scalar(a == b) - n[a] * n[b]) + n[a] * (dv[b] - along * n[b]));
    };
    put_pair_blocks<dim>(s.i, s.j, turning, [&sink](auto i, auto j, Scalar x) { sink.position(i, j, x); });
  }

  std::vector<Spring> springs_;   // sorted
  std::ptrdiff_t particles_ = 0;  // the least number of particles that the springs need
  // Made when first needed; workspaces, so that one object serves one caller at a time.
  mutable std::tuple<SpringRows<float, dim, damped>, SpringRows<double, dim, damped>> rows_;
};

/// A network, with SpringDamping{c} a dashpot beside every spring.
template <int dim, class Damping = NoDamping>
[[nodiscard]] SpringNetwork<dim, Damping> spring_network(std::vector<Spring> springs, Damping damping = {}) {
  return SpringNetwork<dim, Damping>{std::move(springs), damping};
}

}}  // namespace phistep::PHISTEP_ABI
