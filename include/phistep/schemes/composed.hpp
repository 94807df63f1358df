/// @file
/// A symmetric scheme of order 2, composed with itself to order 8: with Φ_h one of its steps,
///
///     Φ_{γ_17 Δt} ∘ … ∘ Φ_{γ_1 Δt},     γ_{18−i} = γ_i,     Σ γ_i = 1                                            (1)
///
/// W. Kahan & R.-C. Li, Math. Comp. 66 (1997) 1089, the seventeen stages of order 8 (also E. Hairer, C. Lubich & G. Wanner,
/// Geometric Numerical Integration, V.3, eq. 3.11); the centre is what the others leave of 1.
///
/// For forces that depend on v, where kick_drift.hpp is none: magnetic fields, rotating frames, a drive. It solves what the
/// scheme solves: with velocity Verlet a local equation for v in each substep.
///
/// **Not with dissipation.** Some γ_i are negative, as they must be beyond order 2: such a substep goes backward in time, and
/// what friction damps forward grows there, by e^{c|γ_i|Δt}; an implicit one meets 1 − φλγ_iΔt = 0. Friction that is slow
/// beside Δt does no harm, stiff friction blows up: there tr_bdf2 or a Rosenbrock scheme serves.
#pragma once

#include <cstddef>
#include <string>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/schemes/kick_drift.hpp"
#include "phistep/schemes/velocity_verlet.hpp"
#include "phistep/step/kernel/scheme_on.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// γ_1 … γ_8
struct KahanLi8 {
  static constexpr int order = 8;
  static constexpr std::size_t count = 17;
  static constexpr long double gamma[] = {.13020248308889008088L, .56116298177510838456L,  -.38947496264484728641L,
                                          .15884190655515560090L, -.39590389413323757734L, .18453964097831570709L,
                                          .25837438768632204729L, .29501172360931029887L};
};

/// (1) over a scheme.
template <class Scheme>
struct Composed {
  static constexpr SchemeFacts facts{.motion_only = Scheme::facts.motion_only,
                                     .is_explicit = Scheme::facts.is_explicit,
                                     .is_symplectic = Scheme::facts.is_symplectic,
                                     .is_a_stable = false,  // some substeps go backward
                                     .is_l_stable = false,
                                     .energy = EnergyBalance::rest};
  [[no_unique_address]] Scheme scheme;
  [[nodiscard]] static constexpr int order() { return KahanLi8::order; }
  [[nodiscard]] static std::string name() {
    std::string name = "composed(";  // by +, g++ 12 warns of an overlap that isn't there
    return name.append(Scheme::name()).append(1, ')');
  }
};
/// Velocity Verlet, the trapezoidal rule or the midpoint rule to order 8.
template <class Scheme>
[[nodiscard]] constexpr Composed<Scheme> composed(Scheme scheme) {
  return {scheme};
}

template <class Scheme, State S>
class SchemeOn<Composed<Scheme>, S> : public SchemeDefaults {
  using Inner = SchemeOn<Scheme, S>;
  static_assert(
      !Inner::looks_back,
      "phistep: composed(scheme) takes a scheme that is symmetric in time: velocity_verlet, trapezoidal or midpoint");

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs = [] {
    KernelNeeds inner = Inner::template needs<Rhs>;
    inner.passes = 0;
    return inner;
  }();

  SchemeOn(const Composed<Scheme>& composed, const Plain& y) : inner_{composed.scheme, y}, from_{y} {}
  void resize(const Plain& y) {
    inner_.resize(y);
    from_ = y;
  }
  [[nodiscard]] static int order() { return KahanLi8::order; }

  [[nodiscard]] static bool leaves_force() { return false; }  // the last part has

  [[nodiscard]] Outcome step(auto& eq) {
    copy_blocks<S>(eq.next, eq.y);
    Scalar share{0};
    for (std::size_t i = 0; i < KahanLi8::count; ++i) {
      copy_blocks<S>(from_, eq.next);
      auto part = eq.part(from_, eq.t + share * eq.dt, gamma(i) * eq.dt, eq.next);
      if (const Outcome bad = take_step(inner_, part); failed(bad)) return bad;
      eq.ends_as(part);
      share += gamma(i);
    }
    return Outcome::success;
  }

  [[nodiscard]] static constexpr Scalar gamma(std::size_t i) {
    return symmetric_coefficient<Scalar>(KahanLi8::gamma, KahanLi8::count, i);
  }

 private:
  Inner inner_;
  Plain from_;
};

}}  // namespace phistep::PHISTEP_ABI
