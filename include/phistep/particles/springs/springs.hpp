/// @file
/// A network of linear springs between particles, with or without dashpots.
///
/// Force on i from the spring (i, j) with d = r_j − r_i, ℓ = |d|, n = d/ℓ:   f = [k (ℓ − L) + c n·(v_j − v_i)] n
/// and its tangent along and across n:  ∂f/∂r_j = B = k n nᵀ + k (1 − L/ℓ) (I − n nᵀ), without the dashpot's part in r.
/// Where ℓ = 0, n is not defined and f = 0, the mean over all n: such a spring pushes again as soon as its ends differ.
#pragma once

#include <Eigen/Core>

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
#include "phistep/base/version.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/particles/springs/spring_rows.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// One spring.
struct Spring {
  std::ptrdiff_t i, j;  ///< its two particles
  double stiffness;     ///< k [force/length]
  double length;        ///< L at rest [length]
};

/// The springs that a network was made of, in the order given. To change one, make a new network.
class SpringList {
 public:
  explicit SpringList(std::vector<Spring> list) : list_(std::move(list)) {}
  [[nodiscard]] auto begin() const { return list_.begin(); }
  [[nodiscard]] auto end() const { return list_.end(); }
  [[nodiscard]] std::size_t size() const { return list_.size(); }
  [[nodiscard]] bool empty() const { return list_.empty(); }
  [[nodiscard]] const Spring& operator[](std::size_t s) const { return list_[s]; }

 private:
  std::vector<Spring> list_;
};

/// No dashpots: the force ignores v, and says so by its type.
struct NoDamping {};
/// A dashpot beside every spring: c [force·time/length], along the spring.
struct SpringDamping {
  double c;  ///< [force·time/length]
};

/// Springs between the particles of a motion whose positions are a flat vector (x₀ y₀ [z₀] x₁ …) or a dim×N matrix.
template <int dim, class Damping = NoDamping>
struct SpringNetwork : ForceTerm {
  SpringList springs;
  [[no_unique_address]] Damping damping;

  static constexpr bool damped = std::is_same_v<Damping, SpringDamping>;
  static constexpr bool uses_velocity = damped, uses_time = false;
  static constexpr Structure structure = Structure::network;
  static constexpr bool has_edges = true, is_symmetric = !damped;
  static constexpr int block = dim;

  /// @throws std::invalid_argument where a spring joins a particle to itself, or has a stiffness or length that is
  /// negative or not finite.
  explicit SpringNetwork(std::vector<Spring> list, Damping d = {}) : springs(std::move(list)), damping(d) {
    for (const Spring& s : springs)
      if (s.i == s.j || s.i < 0 || s.j < 0 || std::max(s.i, s.j) == std::numeric_limits<std::ptrdiff_t>::max() ||
          !(s.stiffness >= 0) || !(s.length >= 0) || !std::isfinite(s.stiffness) || !std::isfinite(s.length))
        throw std::invalid_argument("phistep: spring between particles " + std::to_string(s.i) + " and " +
                                    std::to_string(s.j) + ": needs two particles, stiffness >= 0 and length >= 0");
    if constexpr (damped)
      if (!std::isfinite(damping.c)) throw std::invalid_argument("phistep: a spring's damping must be finite");
    for (const Spring& s : springs) particles_ = std::max({particles_, s.i + 1, s.j + 1});
    // Sorted by their particles, springs find r and f in the caches: shuffled ones took five times as long.
    const auto before = [](const Spring& a, const Spring& b) { return std::minmax(a.i, a.j) < std::minmax(b.i, b.j); };
    if (std::is_sorted(springs.begin(), springs.end(), before)) return;
    sorted_.assign(springs.begin(), springs.end());
    std::stable_sort(sorted_.begin(), sorted_.end(), before);
  }

  void add(auto /*t*/, const auto& y, auto& out) const {
    using Positions = std::remove_cvref_t<decltype(y.r)>;
    static_assert(!Positions::IsRowMajor || Positions::IsVectorAtCompileTime,
                  "phistep: SpringNetwork needs particles as columns of a column-major matrix, or one flat vector");
    using Scalar = typename std::remove_cvref_t<decltype(out.force)>::Scalar;
    const Scalar* const r = y.r.data();
    const Scalar* const v = y.v.data();
    Scalar* const f = out.force.data();
    if (particles_ > y.r.size() / dim)
      throw std::invalid_argument("phistep: a spring names particle " + std::to_string(particles_ - 1) +
                                  ", the state has " + std::to_string(y.r.size() / dim));
    if constexpr (std::same_as<Scalar, double> || std::same_as<Scalar, float>)
      if (add_rows(std::get<SpringRows<Scalar, dim, damped>>(rows_), y, out)) return;
    for_each_sorted([&](const Spring s) {
      const Scalar *const ri = r + dim * s.i, *const rj = r + dim * s.j;
      Scalar d[dim];
      Scalar square{0};
      for (int a = 0; a < dim; ++a) {
        d[a] = rj[a] - ri[a];
        square += d[a] * d[a];
      }
      const Scalar length = std::sqrt(square);
      // Ends in one point: k d = 0 where L = 0; else no direction: NaN, which the step reports, as of pairs and contacts.
      if (length == Scalar{0} && s.stiffness * s.length == 0) return;
      Scalar tension = static_cast<Scalar>(s.stiffness) * (length - static_cast<Scalar>(s.length));
      if constexpr (damped) {
        Scalar along{0};
        for (int a = 0; a < dim; ++a) along += d[a] * (v[dim * s.j + a] - v[dim * s.i + a]);
        tension += static_cast<Scalar>(damping.c) * along / length;
      }
      const Scalar scale = tension / length;
      Scalar *const fi = f + dim * s.i, *const fj = f + dim * s.j;
      for (int a = 0; a < dim; ++a) {
        const Scalar pull = scale * d[a];
        fi[a] += pull;
        fj[a] -= pull;
      }
    });
  }

  /// Calls f(i, j) with the two particles of each spring; `Sleeping` asks for it.
  void for_each_pair(const auto& /*memory*/, auto&& f) const {
    for (const Spring& s : springs) f(s.i, s.j);
  }

  /// ½ Σ k (ℓ − L)² [energy]: the springs' part, dashpots store none
  [[nodiscard]] auto energy(auto /*t*/, const auto& y) const {
    using Scalar = typename std::remove_cvref_t<decltype(y.r)>::Scalar;
    const Scalar* const r = y.r.data();
    Scalar sum{0};
    for_each_sorted([&](const Spring s) {
      Scalar square{0};
      for (int a = 0; a < dim; ++a) {
        const Scalar d = r[dim * s.j + a] - r[dim * s.i + a];
        square += d * d;
      }
      const Scalar stretch = std::sqrt(square) - static_cast<Scalar>(s.length);
      sum += static_cast<Scalar>(s.stiffness) * stretch * stretch;
    });
    return sum / 2;
  }

  /// Pairs, where the sink takes them: ∂f/∂r_j = B as above, ∂f/∂v_j = c n nᵀ. They leave out what the dashpots add to
  /// ∂f/∂r, of the order of c|v_j − v_i|/ℓ, for it is not symmetric. Newton then converges linearly: on a
  /// shaken 3 × 3 net (k ≈ 20, m ≈ 2, backward Euler, Δt = 0.5) it took 8, 12 and 16 iterations to rounding at c = 0.3, 3
  /// and 20, with the complete tangent 5, 5 and 6; at Δt = 0.1 8, 8 and 9, and 7, 8 and 8. Entries are complete.
  void add_jacobian(auto /*t*/, const auto& y, auto& sink) const {
    using Scalar = typename std::remove_cvref_t<decltype(y.r)>::Scalar;
    constexpr bool takes_pairs = requires(const Scalar* n) {
      sink.edge(Eigen::Index{}, Eigen::Index{}, n, PairTangent<Scalar>{}, PairTangent<Scalar>{});
    };
    const Scalar* const r = y.r.data();
    for_each_sorted([&](const Spring s) {
      const Scalar *const ri = r + dim * s.i, *const rj = r + dim * s.j;
      Scalar n[dim];
      Scalar square{0};
      for (int a = 0; a < dim; ++a) {
        n[a] = rj[a] - ri[a];
        square += n[a] * n[a];
      }
      const Scalar length = std::sqrt(square), k = static_cast<Scalar>(s.stiffness), L = static_cast<Scalar>(s.length);
      const Scalar inverse = length > Scalar{0} ? Scalar{1} / length : Scalar{0};
      for (int a = 0; a < dim; ++a) n[a] *= inverse;
      // Without a direction there is no force, but for L = 0, where it is k d.
      PairTangent<Scalar> K, C;
      if (length > Scalar{0}) K = {k, k * (Scalar{1} - L * inverse)};
      else if (L == Scalar{0}) K = {k, k};
      if constexpr (damped) C.along = length > Scalar{0} ? static_cast<Scalar>(damping.c) : Scalar{0};
      if constexpr (takes_pairs) sink.edge(s.i, s.j, n, K, C);
      else put_entries(sink, s, y, n, inverse, K, C);
    });
  }

 private:
  /// Large networks, row by row. Whether this is one depends on nothing but the network.
  template <class Scalar>
  [[nodiscard]] bool add_rows(SpringRows<Scalar, dim, damped>& rows, const auto& y, auto& out) const {
    if (!rows.suits(springs.size(), particles_)) return false;
    if (rows.empty()) sorted_.empty() ? rows.build(springs, particles_) : rows.build(sorted_, particles_);
    Scalar c{0};
    if constexpr (damped) c = static_cast<Scalar>(damping.c);
    const std::uint8_t* still = nullptr;
    if constexpr (requires { y.body.still; })
      if (!y.body.still.empty()) still = y.body.still.data();
    rows.add(y.r.data(), y.v.data(), still, c, out.force.data());
    return true;
  }
  /// The dashpot's part in ∂f/∂r included: c/ℓ [n·Δv (I − nnᵀ) + n ((I − nnᵀ) Δv)ᵀ].
  void put_entries(auto& sink, const Spring& s, const auto& y, const auto* n, auto inverse, const auto& K,
                   const auto& C) const {
    using Scalar = typename std::remove_cvref_t<decltype(y.r)>::Scalar;
    using Vector = Eigen::Matrix<Scalar, dim, 1>;
    using Block = Eigen::Matrix<Scalar, dim, dim>;
    const Eigen::Map<const Vector> direction(n);
    const Block along = direction * direction.transpose(), across = Block::Identity() - along;
    Block B = K.along * along + K.across * across;
    if constexpr (damped) {
      const Vector dv =
          Eigen::Map<const Vector>(y.v.data() + dim * s.j) - Eigen::Map<const Vector>(y.v.data() + dim * s.i);
      const Vector dv_across = across * dv;
      B += C.along * inverse * (direction.dot(dv) * across + direction * dv_across.transpose());
      const Block D = C.along * along;
      put_pair_blocks<dim>(s.i, s.j, D, [&sink](auto i, auto j, Scalar x) { sink.velocity(i, j, x); });
    }
    put_pair_blocks<dim>(s.i, s.j, B, [&sink](auto i, auto j, Scalar x) { sink.position(i, j, x); });
  }
  void for_each_sorted(auto&& f) const {
    if (sorted_.empty())
      for (const Spring& s : springs) f(s);
    else
      for (const Spring& s : sorted_) f(s);
  }

  std::vector<Spring> sorted_;    // empty where `springs` are sorted already
  std::ptrdiff_t particles_ = 0;  // the least number of particles that the springs need
  // Made when first needed; workspaces, so that one object serves one caller at a time.
  mutable std::tuple<SpringRows<float, dim, damped>, SpringRows<double, dim, damped>> rows_;
};

/// A network without dashpots.
template <int dim>
[[nodiscard]] SpringNetwork<dim> spring_network(std::vector<Spring> springs) {
  return SpringNetwork<dim>{std::move(springs)};
}
/// A network with a dashpot of coefficient c [force·time/length] beside every spring.
template <int dim>
[[nodiscard]] SpringNetwork<dim, SpringDamping> spring_network(std::vector<Spring> springs, SpringDamping damping) {
  return SpringNetwork<dim, SpringDamping>{std::move(springs), damping};
}

}}  // namespace phistep::PHISTEP_ABI
