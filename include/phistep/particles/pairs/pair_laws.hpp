/// @file
/// Laws of central forces between pairs, for particles/pairs/pairs.hpp and particles/pairs/all_pairs.hpp.
///
/// A law is called with r² and returns F/r, the force along the line through both divided by their distance,
/// positive = repulsion: so that the force on i is (F/r)(r_i − r_j), and no root is taken where none is needed. From a
/// potential V(r):  F/r = −V'(r)/r = −2 dV/d(r²). It is called with numbers, packs and duals, hence `auto`, and by Pairs
/// with r² up to that of the cutoff only:
///
///     Pairs{[](auto r2) { return 3 / (r2 * r2); }, 2.5};
///
/// One that also has energy(r²) = V has a potential energy. Where particles differ, `tag(body, i)` gives the number that
/// tells them apart (a charge, a type), and the law is called with (r², that of i, that of j).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/numbers/pack_math.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// V = 4ε [(σ/r)¹² − (σ/r)⁶] − shift    [J. E. Lennard-Jones, Proc. R. Soc. A 106, 463 (1924)]
/// F/r = 24ε [2(σ/r)¹² − (σ/r)⁶]/r²
struct LennardJones {
  double epsilon = 1;  ///< depth of the well [energy]
  double sigma = 1;    ///< where V + shift = 0 [length]
  double shift = 0;    ///< [energy]

  /// What `ByType` keeps for each pair of types: σ², 4ε/σ², shift. (σ¹² would be 0, or infinite, in units a float can't square often.)
  [[nodiscard]] std::array<double, 3> coefficients() const {
    const double s2 = sigma * sigma;
    return {s2, 4 * epsilon / s2, shift};
  }
  [[nodiscard]] static auto strength(auto r2, const auto& c) {
    const auto u = c[0] / r2, u3 = u * u * u;
    return u * u3 * (12 * c[1] * u3 - 6 * c[1]);
  }
  [[nodiscard]] static auto potential(auto r2, const auto& c) {
    const auto u = c[0] / r2, u3 = u * u * u;
    return c[0] * c[1] * u3 * (u3 - 1) - c[2];
  }
  [[nodiscard]] auto operator()(auto r2) const { return strength(r2, coefficients()); }
  [[nodiscard]] auto energy(auto r2) const { return potential(r2, coefficients()); }

  /// The same force, and an energy that is 0 at a distance, which then is to be the cutoff.
  [[nodiscard]] LennardJones shifted(double distance) const {
    return {epsilon, sigma, shift + energy(distance * distance)};
  }
};

/// V = A e^(−r/λ)/r    [H. Yukawa, Proc. Phys.-Math. Soc. Jpn. 17, 48 (1935)]
/// F/r = A e^(−r/λ) (1/r + 1/λ)/r²
struct Yukawa {
  double strength;   ///< A [energy·length]
  double screening;  ///< λ [length]

  [[nodiscard]] auto operator()(auto r2) const {
    const auto y = rsqrt(r2);
    return strength * exp(-(r2 * y) / screening) * (y + 1 / screening) * y * y;
  }
  [[nodiscard]] auto energy(auto r2) const {
    const auto y = rsqrt(r2);
    return strength * exp(-(r2 * y) / screening) * y;
  }
};

/// The same between charges, A = k q_i q_j: needs particles with charges.
struct ScreenedCharges {
  double constant;   ///< k [energy·length/charge²]
  double screening;  ///< λ [length]

  [[nodiscard]] auto operator()(auto r2, auto qi, auto qj) const { return qi * qj * Yukawa{constant, screening}(r2); }
  [[nodiscard]] auto energy(auto r2, auto qi, auto qj) const {
    return qi * qj * Yukawa{constant, screening}.energy(r2);
  }
  [[nodiscard]] static auto tag(const auto& body, auto i) {
    if (body.charge.size() == 0) throw std::invalid_argument("phistep: ScreenedCharges needs particles with charges");
    return body.charge[i];
  }
};

/// Attraction and repulsion by powers: on i away from j    F = α₂ r^−β₂ − α₁ r^−β₁
/// [T. I. Zohdi, Introduction to the Modeling and Simulation of Particulate Flows, SIAM (2007), ch. 2]
/// V = ∫_r F ds = α₂ r^(1−β₂)/(β₂ − 1) − α₁ r^(1−β₁)/(β₁ − 1), −α ln r in place of a term whose β is 1
struct NearField {
  double alpha1, beta1;  ///< attraction [force·length^β₁]
  double alpha2, beta2;  ///< repulsion [force·length^β₂]

  [[nodiscard]] auto operator()(auto r2) const {
    return alpha2 * pow(r2, -(beta2 + 1) / 2) - alpha1 * pow(r2, -(beta1 + 1) / 2);
  }
  [[nodiscard]] auto energy(auto r2) const { return primitive(r2, alpha2, beta2) - primitive(r2, alpha1, beta1); }

 private:
  template <class T>
  [[nodiscard]] static T primitive(T r2, double alpha, double beta) {
    if (beta != 1) return alpha / (beta - 1) * pow(r2, (1 - beta) / 2);
    if constexpr (is_pack<T>)
      return T::make([&](int l) { return static_cast<typename T::Scalar>(primitive(r2[l], alpha, beta)); });
    else return static_cast<T>(-alpha / 2 * std::log(r2));
  }
};

/// V = A (1 − r²/D²)²: a repulsion that ends smoothly at D, the cutoff to go with it, and lets particles pass through each
/// other. F/r = 4A (1 − r²/D²)/D²
struct SoftSphere {
  double height;    ///< A [energy]
  double diameter;  ///< D [length]

  [[nodiscard]] auto operator()(auto r2) const {
    const double y = 1 / (diameter * diameter);
    return 4 * height * y * (1 - y * r2);
  }
  [[nodiscard]] auto energy(auto r2) const {
    const auto u = 1 - 1 / (diameter * diameter) * r2;
    return height * u * u;
  }
};

/// One law for each pair of types, with `coefficients()` and the static `strength` and `potential` that LennardJones has.
/// @tparam own_cutoffs  Pairs{ByType{laws, {2.5, 2.0, 2.0, 2.2}}}: each pair of types has its own, else Pairs' serves all
template <class Law, bool own_cutoffs = false>
class ByType {
  using Cutoffs = std::conditional_t<own_cutoffs, std::vector<double>, std::monostate>;

 public:
  /// @param laws     types × types, that of types (a, b) at a·types + b; F_ij = F_ji asks for symmetry
  /// @param cutoffs  types × types [length], >= 0: no force and no energy from there on; 0: none at all
  /// @throws std::invalid_argument where they aren't
  explicit ByType(const std::vector<Law>& laws, Cutoffs cutoffs = {}) : cutoffs_(std::move(cutoffs)) {
    while (types_ * types_ < laws.size()) ++types_;
    if (types_ == 0 || types_ * types_ != laws.size())
      throw std::invalid_argument("phistep: ByType needs types x types laws");
    if constexpr (own_cutoffs)
      if (cutoffs_.size() != laws.size() ||
          !std::all_of(cutoffs_.begin(), cutoffs_.end(), [](double c) { return c >= 0 && std::isfinite(c); }))
        throw std::invalid_argument("phistep: ByType needs types x types cutoffs, finite and >= 0");
    for (const Law& law : laws) {
      const auto own = law.coefficients();
      std::copy(own.begin(), own.end(), table_.emplace_back().begin());
      if constexpr (own_cutoffs) table_.back()[last] = cutoffs_[table_.size() - 1] * cutoffs_[table_.size() - 1];
    }
    for (std::size_t a = 0; a < types_; ++a)
      for (std::size_t b = 0; b < a; ++b)
        if (table_[a * types_ + b] != table_[b * types_ + a])
          throw std::invalid_argument("phistep: ByType has two laws or cutoffs for the types " + std::to_string(b) +
                                      " and " + std::to_string(a));
  }
  [[nodiscard]] auto operator()(auto r2, auto a, auto b) const {
    const auto c = of(a, b);
    return within(r2, c, Law::strength(r2, c));
  }
  [[nodiscard]] auto energy(auto r2, auto a, auto b) const {
    const auto c = of(a, b);
    return within(r2, c, Law::potential(r2, c));
  }
  /// 1 within the pair's own cutoff, 0 beyond.
  [[nodiscard]] auto reaches(auto r2, auto a, auto b) const { return within(r2, of(a, b), decltype(r2){1}); }
  /// types × types [length]
  [[nodiscard]] const Cutoffs& cutoffs() const requires own_cutoffs { return cutoffs_; }
  /// @throws std::invalid_argument that names a particle whose type the table doesn't have
  [[nodiscard]] auto tag(const auto& body, auto i) const {
    const int type = body.type.size() == 0 ? 0 : body.type[i];
    if (type < 0 || static_cast<std::size_t>(type) >= types_)
      throw std::invalid_argument("phistep: particle " + std::to_string(i) + " has type " + std::to_string(type) +
                                  ", the table of laws has " + std::to_string(types_));
    return type;
  }

 private:
  /// The law's, and where there is one the cutoff's square.
  static constexpr std::size_t last = std::tuple_size_v<decltype(std::declval<const Law&>().coefficients())>,
                               count = last + own_cutoffs;
  using Coefficients = std::array<double, count>;

  [[nodiscard]] static auto within(auto r2, const auto& c, auto value) {
    if constexpr (own_cutoffs) return select(r2 < c[last], value, decltype(value){0});
    else return value;
  }

  /// The law of type a, one number, and b, a number or a pack.
  template <class T>
  [[nodiscard]] std::array<T, count> of(auto a, T b) const {
    std::array<T, count> c;
    if constexpr (is_pack<T>) {
      const Coefficients* const row = table_.data() + static_cast<std::size_t>(a[0]) * types_;
      if (T::width > 2 && types_ <= 4) {  // measured: AVX-512 with two types in 0.73 of the time of loads
        unrolled<count>([&](auto k) { c[k] = T{(*row)[k]}; });
        for (std::size_t type = 1; type < types_; ++type) {
          const auto is = b == T{type};
          unrolled<count>([&](auto k) { c[k] = select(is, T{row[type][k]}, c[k]); });
        }
      } else {
        const Coefficients* lane[T::width];
        unrolled<T::width>([&](auto l) { lane[l] = row + static_cast<std::ptrdiff_t>(b[l]); });
        unrolled<count>(
            [&](auto k) { c[k] = T::make([&](int l) { return static_cast<typename T::Scalar>((*lane[l])[k]); }); });
      }
    } else {
      const Coefficients& from = table_[static_cast<std::size_t>(a) * types_ + static_cast<std::size_t>(b)];
      for (std::size_t k = 0; k < count; ++k) c[k] = static_cast<T>(from[k]);
    }
    return c;
  }

  std::size_t types_ = 0;
  std::vector<Coefficients> table_;
  Cutoffs cutoffs_;
};
template <class Law>
ByType(const std::vector<Law>&, const std::vector<double>&) -> ByType<Law, true>;

/// The table of unlike pairs by the rules of Lorentz and Berthelot: σ_ab = (σ_a + σ_b)/2, ε_ab = √(ε_a ε_b); no shifts.
template <class Law = LennardJones>
[[nodiscard]] ByType<Law> lorentz_berthelot(const std::vector<Law>& like) {
  std::vector<Law> all;
  for (const Law& a : like)
    for (const Law& b : like) all.push_back(Law{std::sqrt(a.epsilon * b.epsilon), (a.sigma + b.sigma) / 2});
  return ByType<Law>{all};
}

}}  // namespace phistep::PHISTEP_ABI
