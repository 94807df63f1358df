/// @file
/// What a filtered estimate hides where a rate falls. An estimate e₀ of a stiff step is filtered by the matrix of its start,
///
///     e = W₀⁻¹ M e₀,     W₀ = M − γJ(t, y),                                                                     (1)
///
/// or components long at rest would rule Δt. But what the step hands on is damped by W₁ = M − γJ(t⁺, y⁺): where rates fall
/// within the step, (1) is too small by as much as they fall. With P = W₀⁻¹ γ(J₁ − J₀),
///
///     W₁⁻¹ M e₀ = e + p + Pp + P²p + …,     p = Pe,                                                             (2)
///
/// whose sum along p is p/(1−ρ), and no more than W₀p. ρ = ⟨W₀p, W₀Pp⟩/⟨W₀p, W₀p⟩, in units of the tolerance: in p itself what
/// has fallen may be less than the rounding in J₁x, which is a difference of Ψ at the end. γJ₀x = M x − W₀x is known of e by
/// (1) and of p by its making.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/equation/explicit_update.hpp"
#include "phistep/step/mass/bound_masses.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Corrects the estimates of a kernel's traced steps. Allocates with the first one.
template <State S>
class FallingRates {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;

  /// A copied stepper copies this: it must not read what was never written.
  FallingRates() {
    for (Plain* x : {&unfiltered_, &p_, &moved_, &probe_}) set_zero(Blocks<S>::all(*x));
    for (Rate* x : {&end_, &beside_}) set_zero(Rate::blocks(*x));
  }
  /// x is e₀, which the filter has not seen yet.
  void keep(const Plain& x) {
    fit(x);
    copy_blocks<S>(unfiltered_, x);
  }
  /// x is M e₀.
  void keep_product(const Plain& x, const auto& masses) {
    keep(x);
    static_cast<void>(divide_by_mass(Blocks<S>::solved(unfiltered_), masses));
  }
  /// to += γ (M⁻¹Ψ(t⁺, y⁺) − y'⁺): what an iteration that believed W₀ has left of the equation at the end.
  [[nodiscard]] Outcome add_defect(auto& eq, Scalar gamma, Plain& to) {
    if (const Outcome bad = eq.reach_end(); failed(bad)) return bad;
    fit(to);
    copy_blocks<S>(moved_, to);
    assign_solved<S>(moved_, in_rate<S>(eq.psi));
    static_cast<void>(divide_by_mass(Blocks<S>::solved(moved_), eq.rhs().masses()));
    add_solved<S>(to, gamma * (in<S>(moved_) - in<S>(eq.trace.end)));
    return Outcome::success;
  }
  /// trace.error is e, and becomes (2). No force call unless e₀ is more than allowed and e is not, then one, or three.
  /// @param allowed       in units of the tolerance
  /// @param knows_beside  psi is Ψ(t⁺, y⁺ − e), which spares the first
  [[nodiscard]] Outcome see(auto& eq, const Gamma<Scalar>& gamma, double allowed, bool knows_beside) {
    Plain& e = eq.trace.error;
    const auto size = [&eq](const Plain& x) { return eq.size_of(x, eq.next); };
    // What is smaller than `least` does no harm.
    const double hidden = eq.size_at_most(unfiltered_);
    if (!(hidden > 0.2 * allowed)) return Outcome::success;
    const double filtered = size(e), least = std::max(0.1 * allowed, filtered);
    if (!(filtered <= allowed && hidden > 2 * least)) return Outcome::success;
    if (knows_beside) beside_ = eq.psi;
    if (const Outcome bad = eq.reach_end(); failed(bad)) return bad;
    end_ = eq.psi;
    if (knows_beside) p_changes(eq, gamma, beside_, end_);
    else if (!is_known_at(eq, gamma, e)) return Outcome::success;
    else p_changes(eq, gamma, end_, beside_);
    add_solved<S>(p_, in<S>(unfiltered_) - in<S>(e));
    if (!(eq.size_at_most(p_) > least)) return Outcome::success;
    drop_roundings(eq, gamma);
    const double most = size(p_);  // ‖W₀p‖
    if (!(most > least)) return Outcome::success;
    moved_ = unfiltered_ = p_;
    if (const Outcome bad = filter(eq, gamma, unfiltered_); failed(bad)) return bad;
    const double first = size(unfiltered_);
    if (!(first > 0) || !is_known_at(eq, gamma, unfiltered_)) return Outcome::success;
    p_changes(eq, gamma, end_, beside_);
    add_solved<S>(p_, in<S>(moved_) - in<S>(unfiltered_));
    const double rho = along(eq.trace.weight), sum = rho < 1 ? 1 / (1 - rho) : most / first;
    const auto by = static_cast<Scalar>(std::min(sum, most / first));
    if (std::isfinite(by)) add<S>(e, by * in<S>(unfiltered_));
    // A rate that falls by so much in a step has jumped, and where in the step is not known.
    if (size(e) > 10 * filtered) assign<S>(e, Scalar{10} * in<S>(e));
    return Outcome::success;
  }

 private:
  void fit(const Plain& like) {
    if (same_shape<Plain>(probe_, like)) return;
    for (Plain* x : {&unfiltered_, &p_, &moved_, &probe_}) *x = like;
    end_ = beside_ = make_rate<S>(like);
  }
  /// beside_ = Ψ(t⁺, y⁺ + x). False where it isn't finite.
  [[nodiscard]] bool is_known_at(auto& eq, const Gamma<Scalar>& gamma, const Plain& x) {
    probe_ = eq.next;
    add<S>(probe_, in<S>(x));
    if constexpr (Blocks<S>::drifts && !std::remove_cvref_t<decltype(eq)>::needs.stages)
      position_of<S>(probe_) = position_of<S>(eq.next) + gamma.drift * velocity_of<S>(x);
    beside_ = end_;
    eq.rhs().evaluate_into(eq.t + eq.dt, probe_, beside_);
    return all_finite(Rate::blocks(beside_));
  }
  /// p = γ M⁻¹(to − from)
  void p_changes(auto& eq, const Gamma<Scalar>& gamma, const Rate& from, const Rate& to) {
    if constexpr (Blocks<S>::drifts) position_of<S>(p_).setZero();
    assign_solved<S>(p_, gamma.force * (in_rate<S>(to) - in_rate<S>(from)));
    static_cast<void>(divide_by_mass(Blocks<S>::solved(p_), eq.rhs().masses()));
  }
  /// Makes 0 of p what roundings of y⁺ make of Ψ: rates that haven't fallen, of components that e hardly moves.
  void drop_roundings(auto& eq, const Gamma<Scalar>& gamma) {
    probe_ = eq.next;
    move_numbers(probe_, 0, 4 * std::numeric_limits<Scalar>::epsilon());
    beside_ = end_;
    eq.rhs().evaluate_into(eq.t + eq.dt, probe_, beside_);
    if (!all_finite(Rate::blocks(beside_))) return;
    moved_ = p_;
    p_changes(eq, gamma, end_, beside_);
    for_each_number([](std::size_t, Scalar& rounding,
                       Scalar p) { rounding = std::abs(p) <= 4 * std::abs(rounding) ? Scalar{0} : p; },
                    Blocks<S>::all(p_), Blocks<S>::all(std::as_const(moved_)));
  }
  /// x ← W₀⁻¹ M x
  template <class Eq>
  [[nodiscard]] Outcome filter(Eq& eq, const Gamma<Scalar>& gamma, Plain& x) {
    Outcome outcome = Outcome::success;
    if constexpr (Eq::needs.stages) {
      probe_ = x;
      set_zero(Blocks<S>::all(x));
      eq.add_mass_product(x, Scalar{1}, probe_);
      outcome = eq.solve(gamma.force, x);
    } else {
      outcome = eq.filter_once(x);
    }
    if constexpr (Blocks<S>::drifts) position_of<S>(x) = gamma.drift * velocity_of<S>(x);
    return outcome;
  }
  /// ⟨W₀p, W₀Pp⟩/⟨W₀p, W₀p⟩
  [[nodiscard]] double along(const Plain& weight) const {
    double product = 0, square = 0;
    for_each_number(
        [&](std::size_t, Scalar w, Scalar p, Scalar q) {
          const double x = static_cast<double>(w) * static_cast<double>(p);
          product += x * static_cast<double>(w) * static_cast<double>(q);
          square += x * x;
        },
        Blocks<S>::solved(weight), Blocks<S>::solved(moved_), Blocks<S>::solved(p_));
    return product / square;
  }

  Plain unfiltered_;     // e₀, then p
  Plain p_;              // W₀p, then W₀Pp
  Plain moved_, probe_;  // W₀p; scratch
  Rate end_, beside_;    // Ψ(t⁺, y⁺), and beside it
};

}}  // namespace phistep::PHISTEP_ABI
