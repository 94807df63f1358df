/// @file
/// A motion's force in the parts that have accounts of their own in an energy balance, Ψ = F + D + X:
///
///     F   conservative: of the terms with an energy; of a damped spring, its force at v = 0
///     D   damping: of the terms that use the velocity; of a damped spring, the rest of its force
///     X   external: of the others
#pragma once

#include <tuple>
#include <type_traits>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/force/at.hpp"
#include "phistep/force/evaluate.hpp"
#include "phistep/force/signature.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// F, D and X at one place.
template <class Rate>
struct ForceParts {
  using Block = std::remove_cvref_t<decltype(std::get<0>(Rate::blocks(std::declval<Rate&>())))>;  // like v
  Rate conservative, damping, external;

  static Block& of(Rate& rate) { return std::get<0>(Rate::blocks(rate)); }
  [[nodiscard]] Block& F() { return of(conservative); }
  [[nodiscard]] Block& D() { return of(damping); }
  [[nodiscard]] Block& X() { return of(external); }
  /// Ψ, an expression.
  [[nodiscard]] auto sum() { return F() + D() + X(); }
};

/// Evaluates them for a stepper's force.
template <class Stepper>
class ForceSplitter {
 public:
  using S = typename Stepper::StateType;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Scalar = ScalarOf<S>;
  using Force = std::remove_reference_t<decltype(std::declval<Stepper&>().force())>;
  using Masses = std::remove_reference_t<decltype(std::declval<Stepper&>().masses())>;
  using View = std::remove_cvref_t<decltype(Blocks<S>::view(std::declval<const Plain&>(), std::declval<Masses&>()))>;

 private:
  template <class F>
  using TraitsOf = ForceTraits<std::remove_const_t<F>, View, Rate>;
  struct Uses {
    bool velocity, time;
  };
  template <class F>
  struct UsesOf {
    static constexpr bool counts = HasEnergy<F, View>;
    static constexpr Uses value{counts && TraitsOf<F>::uses_velocity, counts&& TraitsOf<F>::uses_time};
  };
  template <class... T>
  struct UsesOf<Sum<T...>> {
    static constexpr Uses value{(UsesOf<Unwrapped<T>>::value.velocity || ...),
                                (UsesOf<Unwrapped<T>>::value.time || ...)};
  };

 public:
  /// The form of the stepper's energy balance.
  static constexpr EnergyBalance balance = is_split<std::remove_const_t<Force>, typename Stepper::SchemeType>
                                               ? EnergyBalance::rest
                                               : Stepper::SchemeType::facts.energy.value;
  /// What the terms with an energy use besides r.
  static constexpr Uses uses = UsesOf<std::remove_const_t<Force>>::value;

  /// The stepper must outlive this and stay where it is.
  explicit ForceSplitter(Stepper& stepper) : stepper_{&stepper}, force_{&stepper.force()} {
    // A copy may be made before they are filled.
    set_zero(Rate::blocks(part_));
    set_zero(Blocks<S>::all(still_));
  }

  void resize(const Plain& y) {
    part_ = make_rate<S>(y);
    if constexpr (uses.velocity) still_ = y;
  }
  [[nodiscard]] const auto& mass() const { return std::get<0>(stepper_->masses()); }
  /// out = M⁻¹ f
  void accelerate(const auto& f, auto& out) const {
    out = f;
    static_cast<void>(divide_by_mass(out, mass()));
  }
  /// ½ vᵀMv [energy]
  template <class Energy>
  [[nodiscard]] Energy kinetic(const Plain& y) const {
    const Scalar* const v = velocity_of<S>(y).data();
    Energy twice{0};
    mass().for_each_entry(velocity_of<S>(y).size(), [&](Index i, Index j, auto m) {
      twice += static_cast<Energy>(v[i]) * static_cast<Energy>(m) * static_cast<Energy>(v[j]);
    });
    return twice / 2;
  }
  /// V(t, y) [energy]
  [[nodiscard]] Scalar potential(Scalar t, const Plain& y) {
    return static_cast<Scalar>(potential_energy(*force_, t, view(y), stepper_->memory()));
  }
  /// Whether there is no D and no X, and F doesn't depend on t: the energy is what V says.
  [[nodiscard]] bool is_conservative() const {
    bool all = !uses.velocity && !uses.time;
    for_each_summand(*force_, [&all](auto& term) { all = all && has_energy<View>(term); });
    return all;
  }

  /// F, D and X at (t, y). @returns how many force calls that was
  int evaluate(Scalar t, const Plain& y, ForceParts<Rate>& to) {
    if constexpr (uses.velocity) {
      copy_blocks<S>(still_, y);
      velocity_of<S>(still_).setZero();
    }
    for (Rate* rate : {&to.conservative, &to.damping, &to.external}) set_zero(Rate::blocks(*rate));
    add(*force_, t, y, stepper_->memory(), to);
    return uses.velocity ? 2 : 1;
  }

 private:
  [[nodiscard]] View view(const Plain& y) const { return Blocks<S>::view(y, stepper_->masses()); }
  template <class F, class Memory>
  void add(F& force, Scalar t, const Plain& y, const Memory& memory, ForceParts<Rate>& to) {
    if constexpr (is_sum<std::remove_const_t<F>>) {
      for_each_term(force, memory, [&](auto, auto& term, const auto& its) { add(term, t, y, its, to); });
    } else if (!has_energy<View>(force)) {
      add_force(force, t, view(y), memory, TraitsOf<F>::uses_velocity ? to.damping : to.external);
    } else if constexpr (UsesOf<F>::value.velocity) {
      assign_force(force, t, view(still_), memory, part_);
      to.F() += ForceParts<Rate>::of(part_);
      to.D() -= ForceParts<Rate>::of(part_);
      add_force(force, t, view(y), memory, to.damping);
    } else {
      add_force(force, t, view(y), memory, to.conservative);
    }
  }

  Stepper* stepper_;
  Force* force_;
  Rate part_;    // one term's
  Plain still_;  // the state with v = 0
};

}}  // namespace phistep::PHISTEP_ABI
