/// @file
/// Rannacher's start (Rannacher, Numer. Math. 43 (1984) 309; Giles & Carter, J. Comput. Finance 9 (2006) 89): the first
/// steps as two backward Euler half steps each,
///
///     y½ = y  + ½Δt M⁻¹Ψ(t+½Δt, y½),     y⁺ = y½ + ½Δt M⁻¹Ψ(t+Δt, y⁺),                                          (1)
///
/// then the trapezoidal rule, whose resolve has the coefficient ½Δt too: one matrix for the whole run.
#pragma once

#include <stdexcept>

#include "phistep/base/facts/phi.hpp"
#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/schemes/phi.hpp"
#include "phistep/step/kernel/scheme_on.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Rannacher's start: the first step (or the first `pairs` steps) as two backward Euler half steps each, then the
/// trapezoidal rule. The half steps damp what the trapezoidal rule would let ring, a jump in the data say, at no cost in
/// order and with the same matrix. First means: since the stepper was made or reset.
struct Rannacher {
  static constexpr SchemeFacts facts = AStable{.is_l_stable = false, .energy = EnergyBalance::rest};
  int pairs = 1;  ///< of half steps: 1 for a jump in the data, 2 for a point source (Dirac's δ)

  [[nodiscard]] static constexpr const char* name() { return "rannacher"; }
  [[nodiscard]] static constexpr int order() { return 2; }
  /// @throws std::invalid_argument where n is negative
  [[nodiscard]] constexpr Rannacher operator()(int n) const {
    if (n < 0) throw std::invalid_argument("phistep: rannacher(n) needs n >= 0 pairs of half steps");
    return {n};
  }
};

/// The trapezoidal rule for data that jump: `rannacher`, or `rannacher(2)` for a point source.
inline constexpr Rannacher rannacher{};

template <State S>
class SchemeOn<Rannacher, S> : public SchemeDefaults {
  using Trapezoidal = SchemeOn<SinglePhi<FixedPhi<1, 2>>, S>;

 public:
  using Scalar = ScalarOf<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.solver = true};

  SchemeOn(Rannacher scheme, const auto& y) : scheme_{scheme}, trapezoidal_{trapezoidal, y} {}
  [[nodiscard]] static int order() { return Rannacher::order(); }

  /// Steps of the start that have become the state.
  using Progress = int;
  [[nodiscard]] Progress progress() const { return done_; }
  void resume(Progress done) { done_ = done; }
  void archive(auto& ar) {
    ar("done", done_);
    ar.check(0 <= done_ && done_ <= scheme_.pairs);
  }
  void reset() { done_ = 0; }
  void accepted() { done_ += done_ < scheme_.pairs; }

  [[nodiscard]] Outcome step(auto& eq) const {
    if (done_ >= scheme_.pairs) return trapezoidal_.step(eq);
    const Scalar half = eq.dt / 2;
    copy_blocks<S>(eq.next, eq.y);
    if (const Outcome bad = eq.resolve({half, half}, eq.t + half); failed(bad)) return bad;
    return eq.resolve({half, half}, eq.t + eq.dt);  // (1)
  }

 private:
  Rannacher scheme_;
  [[no_unique_address]] Trapezoidal trapezoidal_;
  int done_ = 0;
};

}}  // namespace phistep::PHISTEP_ABI
