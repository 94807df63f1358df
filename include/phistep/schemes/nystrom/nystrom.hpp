/// @file
/// Explicit Runge-Kutta-Nyström pairs for motion under a force that ignores v, a(t, r) = M⁻¹Ψ(t, r):
///
///     r_i = r + c_i Δt v + Δt² Σ_{j<i} a_ij k_j,   k_i = a(t + c_i Δt, r_i)                                      (1)
///     r⁺  = r + Δt v + Δt² Σ b_j k_j,              v⁺ = v + Δt Σ b'_j k_j                                        (2)
///     e_r = Δt² Σ (b_j − b̂_j) k_j,                 e_v = Δt Σ (b'_j − b̂'_j) k_j                                  (3)
///
/// (Hairer, Nørsett & Wanner, Solving ODEs I, II.14; the pairs themselves are in nystrom_tableaus.hpp.) The step goes on
/// with the formula of higher order, e is the error of the lower one. A last stage at r⁺ is the next step's first.
///
/// `compensated(rkn1210)` rounds r and v once a step, and tells the next step what that took from them. What is left are the
/// roundings of the increments: for long runs at rounding level.
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/numbers/update.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/schemes/explicit_stages.hpp"
#include "phistep/schemes/nystrom/nystrom_tableaus.hpp"
#include "phistep/step/kernel/scheme_on.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// What rounding took from the state in one step, kept for the next: compensated sums (W. Kahan, Comm. ACM 8 (1965) 40;
// E. Hairer, C. Lubich & G. Wanner, Geometric Numerical Integration, VIII.5), one a step and component,
//
//     δ = Δy + lost,   y⁺ = y + δ,   lost⁺ = δ − (y⁺ − y)
//
// It belongs to the state that the last step left, bit for bit: any other starts with none.

template <State S>
class CarriedRounding {
 public:
  using Plain = PlainState<S>;

  void resize(const Plain& y) {
    for (Plain* x : {&lost_, &next_lost_, &end_, &next_end_}) *x = y;
    known_ = false;
  }
  /// A step starts from y.
  void begin(const Plain& y) {
    if (known_ && equal_blocks<S>(y, end_)) return;
    known_ = false;
    set_zero(Blocks<S>::all(lost_));
  }
  [[nodiscard]] const Plain& lost() const { return lost_; }
  [[nodiscard]] Plain& next_lost() { return next_lost_; }
  /// The step ends at `next`, with next_lost().
  void end(const Plain& next) { copy_blocks<S>(next_end_, next); }
  void accepted() {
    std::swap(lost_, next_lost_);
    std::swap(end_, next_end_);
    known_ = true;
  }
  void forget() { known_ = false; }
  void archive(auto& ar) {
    ar("known", known_);
    if (known_) ar.in_place("lost", lost_, "of", end_);
  }

 private:
  Plain lost_, next_lost_;
  Plain end_, next_end_;  // the states that they belong to
  bool known_ = false;
};

/// A pair as a scheme.
template <class Tableau, bool compensates = false>
struct Nystrom {
  static constexpr SchemeFacts facts = ExplicitMotion{.is_symplectic = false, .energy = EnergyBalance::rest};
  [[nodiscard]] static constexpr int order() { return Tableau::order; }
  [[nodiscard]] static constexpr const char* name() { return Tableau::name; }
};

/// Order 8, estimate of order 6, eight force calls a step.
inline constexpr Nystrom<Rkn86> rkn86{};
/// Order 12, estimate of order 10, seventeen force calls a step: for smooth forces and many digits.
inline constexpr Nystrom<Rkn1210> rkn1210{};

/// The scheme with compensated sums.
template <class Tableau, bool compensates>
[[nodiscard]] constexpr Nystrom<Tableau, true> compensated(Nystrom<Tableau, compensates>) {
  return {};
}

template <class Tableau, bool compensates, State S>
class SchemeOn<Nystrom<Tableau, compensates>, S> : public SchemeDefaults {
  static_assert(!FieldState<S>, "phistep: Nystrom pairs take no fields: take tsit5, dop853 or velocity_verlet");
  static_assert(Blocks<S>::drifts,
                "phistep: a Runge-Kutta-Nystrom pair needs a motion (r, v), not a first-order state");
  static constexpr std::size_t stages = Tableau::stages, last = stages - 1;
  /// Weights of the k_j in (2) and (3), as types, so that sums are unrolled, and zeros are left out.
  template <std::size_t block>
  using End = TableRow<Tableau::b, block, stages>;
  template <std::size_t block>
  using Error = DifferenceOfWeights<End<block>, TableRow<Tableau::b_hat, block, stages>>;

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs = [] {
    static_assert(!Rhs::couples_unknowns,
                  "phistep: a Runge-Kutta-Nystrom pair needs a force that ignores v: write f(r), or a struct with "
                  "uses_velocity = false");
    return KernelNeeds{.position = false, .carries = Tableau::first_is_last && can_carry<Rhs>};
  }();

  SchemeOn(Nystrom<Tableau, compensates>, const Plain& y) { resize(y); }
  void resize(const Plain& y) {
    k_.resize(y);
    rounding_.resize(y);
  }
  [[nodiscard]] static int order() { return Tableau::order; }
  /// The power of Δt in the estimate.
  [[nodiscard]] static int error_order() { return Tableau::error_order; }

  static constexpr bool traces = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }

  [[nodiscard]] Outcome step(auto& eq) {
    if (const Outcome bad = eq.slope_at_start(k_[0]); failed(bad)) return bad;
    if (!go(eq)) {
      k_.blame(eq.psi);
      return Outcome::non_finite_state;
    }
    eq.end_with_psi();
    return Outcome::success;
  }
  /// The slope at the end, and (3)
  [[nodiscard]] Outcome error(auto& eq) {
    auto& trace = eq.trace;
    k_.template put<Error<0>>(eq.dt * eq.dt, position_of<S>(trace.error));
    k_.template put<Error<1>>(eq.dt, velocity_of<S>(trace.error));
    if constexpr (Tableau::first_is_last) {
      position_of<S>(trace.end) = velocity_of<S>(eq.next);
      velocity_of<S>(trace.end) = block(k_[last]);
    } else if (!eq.rhs().slope(eq.t + eq.dt, eq.next, trace.end, eq.psi)) {
      return Outcome::non_finite_force;
    }
    // interpolate() takes the slope at r⁺ in place of a last stage that isn't at r⁺.
    if constexpr (!Tableau::first_is_last)
      if (trace.wants_dense) block(k_[last]) = velocity_of<S>(trace.end);
    trace.has_slopes = trace.has_error = true;
    return Outcome::success;
  }
  static constexpr bool interpolates = true;
  static constexpr std::array<double, 2> doubtful_at{Tableau::doubtful[0], Tableau::doubtful[1]};
  void interpolate(Scalar x, Scalar dt, const Plain& y0, const Plain& y1, Plain& out) const {
    NystromInterpolant<Tableau>::template at<S>(x, dt, y0, y1, k_.all(), out);
  }

  void archive(auto& ar) { ar("rounding", rounding_); }
  void forget() { rounding_.forget(); }
  void accepted() { rounding_.accepted(); }

 private:
  [[nodiscard]] static auto& block(auto& k) { return std::get<0>(Rate::blocks(k)); }
  static constexpr int size =
      std::remove_cvref_t<decltype(std::get<0>(Rate::blocks(std::declval<Rate&>())))>::SizeAtCompileTime;

  /// (1) from k_0, and (2). False: something isn't finite.
  [[nodiscard]] bool go(auto& eq) {
    if constexpr (compensates) rounding_.begin(eq.y);
    velocity_of<S>(eq.next) = velocity_of<S>(eq.y);  // for a force that sees the whole state; a(t, r) ignores v
    const bool arrived = [&]<std::size_t... i>(std::index_sequence<i...>) { return (stage<i + 1>(eq) && ...); }
    (std::make_index_sequence<last>{});
    if (!arrived) return false;
    bool finite = true;
    if constexpr (!Tableau::first_is_last) finite = move<End<0>, true>(eq, 1);
    const auto kick = [dt = eq.dt, sum = k_.template sum<End<1>>()](auto i) { return dt * sum(i); };
    finite = put<1, true>(eq.next, eq.y, kick) && finite;
    if constexpr (compensates) rounding_.end(eq.next);
    return finite;
  }
  template <std::size_t i>
  [[nodiscard]] bool stage(auto& eq) {
    constexpr bool at_end = i == last && Tableau::first_is_last;
    if (!move<TableRow<Tableau::a, i, i>, at_end>(eq, Tableau::c[i])) return false;
    // Stores Ψ for the next step, not M⁻¹Ψ.
    eq.rhs().evaluate_into(eq.t + static_cast<Scalar>(Tableau::c[i]) * eq.dt, eq.next, at_end ? eq.psi : k_[i]);
    if constexpr (at_end) k_[i] = eq.psi;
    return divide_by_mass(RateOf<S>::blocks(k_[i]), eq.rhs().masses());
  }
  /// next.r = r + c Δt v + Δt² Σ w_j k_j
  template <class Weights, bool at_end>
  [[nodiscard]] bool move(auto& eq, long double c) {
    const Input<Scalar> v{velocity_of<S>(eq.y).data()};
    const Scalar dt = eq.dt, share = static_cast<Scalar>(c);
    if constexpr (compensates) {
      const auto rest = static_cast<Scalar>(c - static_cast<long double>(share));
      const auto increment = [=, sum = k_.template sum<Weights>()](auto i) {
        return dt * (share * v[i] + (rest * v[i] + dt * sum(i)));
      };
      return put<0, at_end>(eq.next, eq.y, increment);
    } else {
      const auto increment = [drift = share * dt, kick = dt * dt, v, sum = k_.template sum<Weights>()](auto i) {
        return sum.add_to(drift * v[i], kick, i);
      };
      return put<0, at_end>(eq.next, eq.y, increment);
    }
  }
  /// to = from + increment(i) in block n. False: it isn't finite.
  template <std::size_t n, bool at_end>
  [[nodiscard]] bool put(Plain& to, const Plain& from, auto increment) {
    const Input<Scalar> y{std::get<n>(Blocks<S>::all(from)).data()};
    auto& out = std::get<n>(Blocks<S>::all(to));
    if constexpr (at_end && compensates) {
      const Input<Scalar> lost{std::get<n>(Blocks<S>::all(rounding_.lost())).data()};
      const auto kernel = [=](auto i, auto& y1, auto& lost1) {
        const auto delta = increment(i) + lost[i];
        y1 = y[i] + delta;
        lost1 = delta - (y1 - y[i]);
      };
      return update_block<size>(out.size(), kernel, out.data(),
                                std::get<n>(Blocks<S>::all(rounding_.next_lost())).data());
    } else {
      const auto kernel = [=](auto i, auto& y1) { y1 = y[i] + increment(i); };
      return update_block<size>(out.size(), kernel, out.data());
    }
  }
  ExplicitStages<S, stages, compensates> k_;
  std::conditional_t<compensates, CarriedRounding<S>, SchemeDefaults> rounding_;  // or nothing
};

}}  // namespace phistep::PHISTEP_ABI
