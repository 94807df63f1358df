/// @file
/// Every pair of particles acts on each other along their line, at any distance:
///
///     F_i = Σ_j w_i w_j f(r²) (r_i − r_j),   r = |r_i − r_j|,   f: force over distance, > 0 where it repels
///
/// by direct summation, N²/2 evaluations of the law. The weights are masses (gravity), charges (Coulomb) or 1.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/numbers/dual.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/particles/pairs/pair_tournament.hpp"
#include "phistep/step/mass/mass.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// What multiplies a pair's law: w_i w_j.
enum class PairWeight { one, mass, charge };

/// −G (r² + ε²)^(−3/2): Newton's law between Plummer's spheres of radius ε (Dyer & Ip, ApJ 409 (1993) 60).
struct SoftenedGravity {
  double G;        ///< [force·length²/mass²]
  double epsilon;  ///< ε [length]; 0: Newton's points
  static constexpr PairWeight weight = PairWeight::mass;

  [[nodiscard]] double factor() const { return -G; }
  [[nodiscard]] auto without_factor(auto r2) const { return rsqrt3(r2 + decltype(r2)(epsilon * epsilon)); }
  [[nodiscard]] auto operator()(auto r2) const { return decltype(r2)(factor()) * without_factor(r2); }
  /// −G/√(r² + ε²) [energy/mass²]
  [[nodiscard]] auto energy(auto r2) const { return decltype(r2)(-G) * rsqrt(r2 + decltype(r2)(epsilon * epsilon)); }
};

/// k (r² + ε²)^(−3/2) between charges: k = 1/(4π ε₀) in SI units.
struct Coulomb {
  double k;            ///< [force·length²/charge²]; in SI 8.98755e9 N m²/C²
  double epsilon = 0;  ///< softening ε [length]
  static constexpr PairWeight weight = PairWeight::charge;

  [[nodiscard]] double factor() const { return k; }
  [[nodiscard]] auto without_factor(auto r2) const { return rsqrt3(r2 + decltype(r2)(epsilon * epsilon)); }
  [[nodiscard]] auto operator()(auto r2) const { return decltype(r2)(factor()) * without_factor(r2); }
  /// k/√(r² + ε²) [energy/charge²]
  [[nodiscard]] auto energy(auto r2) const { return decltype(r2)(k) * rsqrt(r2 + decltype(r2)(epsilon * epsilon)); }
};

/// The weight of a law that names none is 1.
template <class Law>
inline constexpr PairWeight pair_weight = PairWeight::one;
template <class Law>
  requires requires { PairWeight{Law::weight}; }
inline constexpr PairWeight pair_weight<Law> = Law::weight;

/// The force of a pair law between all pairs.
///
///     auto force = AllPairs{SoftenedGravity{G, epsilon}};
///     auto mine = AllPairs{[](auto r2) { return exp(-r2); }};           // weights 1; r2 is a number, a Pack or a Dual
///     auto heavy = all_pairs<PairWeight::mass>([](auto r2) { return -rsqrt(r2); });
///
/// For Particles, and for motions of dim × N matrices, in open space. Particles held still act, but get no force. Two at one place get NaN or
/// infinity where the law has no limit, and so does one at no finite place, which the others' forces leave out. If the law has energy(r²),
/// the term has an energy. One object serves one caller at a time.
template <class Law, PairWeight weight = pair_weight<Law>>
class AllPairs : public ForceTerm {
  template <class View>
  struct Shape {
    using Positions = std::remove_cvref_t<decltype(std::declval<View>().r)>;
    using Scalar = typename Positions::Scalar;
    static constexpr int dim = Positions::RowsAtCompileTime;
    static_assert(1 <= dim && dim <= 3 && !Positions::IsRowMajor && int{Positions::ColsAtCompileTime} != 1,
                  "phistep: AllPairs needs particles as the columns of a matrix with a fixed number of rows, such as "
                  "Eigen::Matrix3Xd");
  };

 public:
  Law law;  ///< g(r²) = F/r, and its energy where it has one

  static constexpr bool uses_velocity = false, uses_time = false, is_symmetric = true;
  static constexpr Structure structure = Structure::dense;

  /// @throws std::invalid_argument where the law's numbers are invalid
  explicit AllPairs(Law l) : law{std::move(l)} {
    if constexpr (requires { law.factor() + law.epsilon; })
      if (!std::isfinite(law.factor()) || !std::isfinite(law.epsilon) || law.epsilon < 0)
        throw std::invalid_argument("phistep: AllPairs needs a law with finite numbers, and a softening >= 0");
  }

  /// @throws std::invalid_argument where the box is periodic, or the particles lack what weighs them
  void add(auto /*t*/, const auto& y, auto& out) const {
    using Scalar = typename Shape<decltype(y)>::Scalar;
    constexpr int dim = Shape<decltype(y)>::dim;
    const auto w = weights<Scalar>(y);
    if (y.r.cols() <= few<Scalar> && y.r.allFinite()) return add_few<Scalar, dim>(y, w, out);
    const auto slots = fill<Scalar, dim>(y, w);
    double factor = 1;
    if constexpr (requires { law.factor(); }) {
      factor = law.factor();
      slots.play([f = law](auto r2) { return f.without_factor(r2); });
    } else {
      slots.play(law);
    }
    const Scalar* const r = y.r.data();
    Scalar* const force = out.force.data();
    for (Eigen::Index i = 0, s = 0; i < y.r.cols(); ++i) {  // s: its slot, as `fill` has placed it
      if (is_still(y, i)) continue;
      Scalar scale = static_cast<Scalar>(factor) * w(i);
      for (int a = 0; a < dim; ++a) scale += r[dim * i + a] - r[dim * i + a];  // NaN at no finite place
      for (int a = 0; a < dim; ++a) force[dim * i + a] += scale * slots.sum(a)[s];
      ++s;
    }
  }

  /// Σ w_i w_j U(r²) over the pairs of which one at least moves [energy]
  template <class View>
  [[nodiscard]] auto energy(auto /*t*/, const View& y) const requires requires(const Law& l) {
    l.energy(y.r(0, 0));
  }
  {
    using Scalar = typename Shape<View>::Scalar;
    const auto slots = fill<Scalar, Shape<View>::dim>(y, weights<Scalar>(y));
    return slots.total([f = law](auto r2) { return f.energy(r2); }) + (y.r - y.r).sum();  // NaN unless r is finite
  }

  /// ∂F_i/∂r_j = −w_i w_j (f I + 2 f' d dᵀ), d = r_i − r_j, f' = df/dr² by differentiation of the law. Every entry of a
  /// dense matrix: for few particles.
  void add_jacobian(auto /*t*/, const auto& y, auto& sink) const {
    using Scalar = typename Shape<decltype(y)>::Scalar;
    constexpr int dim = Shape<decltype(y)>::dim;
    using Block = Eigen::Matrix<Scalar, dim, dim>;
    const auto w = weights<Scalar>(y);
    for (Eigen::Index j = 1; j < y.r.cols(); ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const Eigen::Matrix<Scalar, dim, 1> d = y.r.col(i) - y.r.col(j);
        const auto f = law(Dual<Scalar>{d.squaredNorm(), Scalar{1}});
        const Block B = -w(i) * w(j) * (f.x * Block::Identity() + 2 * f.slope * d * d.transpose());
        put_pair_blocks<dim>(i, j, B, [&](Eigen::Index row, Eigen::Index column, Scalar x) {
          if (!is_still(y, row / dim)) sink.position(row, column, x);
        });
      }
  }

 private:
  // Measured: so many pairs one by one, on the state as it lies, are as fast (g++ 12, AVX-512, AVX2: 6, SSE2: 14).
  template <class Scalar>
  static constexpr Eigen::Index few = native_width<Scalar> >= 4 ? 6 : 14;

  /// i ↦ w_i
  template <class Scalar>
  [[nodiscard]] static auto weights(const auto& y) {
    if constexpr (HasBody<decltype(y)>)
      if (!y.body.box.is_open())
        throw std::invalid_argument("phistep: AllPairs doesn't sum over the images of a periodic box");
    if constexpr (weight == PairWeight::one) {
      return [](Eigen::Index) { return Scalar{1}; };
    } else if constexpr (weight == PairWeight::charge) {
      static_assert(HasBody<decltype(y)>, "phistep: AllPairs needs charges, which Particles have");
      if (y.body.charge.size() != y.r.cols())
        throw std::invalid_argument("phistep: the particles have no charges: set_charge(…)");
      return [q = y.body.charge.data()](Eigen::Index i) { return q[i]; };
    } else if constexpr (HasBody<decltype(y)>) {
      return [m = y.body.mass.data()](Eigen::Index i) { return m[i]; };
    } else {
      using Mass = std::remove_cvref_t<decltype(y.mass)>;
      static_assert(!Mass::is_matrix, "phistep: AllPairs needs a mass a particle, not a mass matrix");
      // A particle's mass: that of its first component.
      return [&mass = y.mass, dim = y.r.rows()](Eigen::Index i) { return static_cast<Scalar>(mass[dim * i]); };
    }
  }

  template <class Scalar, int dim>
  [[nodiscard]] auto fill(const auto& y, const auto& w) const {
    const Eigen::Index n = y.r.cols();
    Eigen::Index still = 0;
    for (Eigen::Index i = 0; i < n; ++i) still += is_still(y, i) ? 1 : 0;
    const detail::PairTournament<Scalar, dim> slots(n - still, still, memory_);
    const Scalar* const r = y.r.data();
    Eigen::Index moving = 0, held = slots.first_still();
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index s = is_still(y, i) ? held++ : moving++;
      for (int a = 0; a < dim; ++a) slots.r(a)[s] = r[dim * i + a];
      slots.weight()[s] = w(i);
    }
    if (moving > 0) slots.pad();
    return slots;
  }

  /// A handful doesn't fill the lanes: pair by pair.
  template <class Scalar, int dim>
  void add_few(const auto& y, const auto& w, auto& out) const {
    for (Eigen::Index j = 1; j < y.r.cols(); ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const Eigen::Matrix<Scalar, dim, 1> d = y.r.col(i) - y.r.col(j);
        const Eigen::Matrix<Scalar, dim, 1> f = w(i) * w(j) * static_cast<Scalar>(law(d.squaredNorm())) * d;
        if (!is_still(y, i)) out.force.col(i) += f;
        if (!is_still(y, j)) out.force.col(j) -= f;
      }
  }

  mutable std::vector<unsigned char> memory_;
};
template <class Law>
AllPairs(Law) -> AllPairs<Law>;

/// With weights that the law doesn't name: a lambda's.
template <PairWeight weight, class Law>
[[nodiscard]] AllPairs<Law, weight> all_pairs(Law law) {
  return AllPairs<Law, weight>{std::move(law)};
}

}}  // namespace phistep::PHISTEP_ABI
