/// @file
/// What implicit Runge-Kutta schemes are made of once their stages are decoupled: one linearization, and with it several
/// complex matrices that are factorized and solved with side by side,
///
///     W_l = λ_l/h M − C − h/λ_l K
///
/// (Hairer & Wanner, Solving ODEs II, sect. IV.8, eq. 8.9).
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/reductions.hpp"
#include "phistep/linear/lanes/lane_system.hpp"
#include "phistep/step/equation/right_hand_side.hpp"
#include "phistep/step/jacobian/tangent_check.hpp"
#include "phistep/step/kernel/kernel.hpp"
#include "phistep/step/solve/linearization.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

template <State S, class Rhs, class LinearSolver>
class ShiftedStages {
  static_assert(
      !FieldState<S>,
      "phistep: radau solves with complex matrices, which a field's solver has none of: take rodas4, rodas5p or "
      "tr_bdf2");

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  static constexpr int lanes = 4;
  using Matrix = Linearization<S, Rhs, LinearSolver, true, true, true>;
  static constexpr bool solves_by_factors = !Matrix::is_iterative;
  using Lanes = LaneSystem<Matrix::row.kind, Matrix::facts, Scalar, lanes>;
  using Shift = LaneShift<Scalar, lanes>;
  static constexpr bool analytic = Matrix::analytic;
  /// An iteration makes up for some of J's errors, but the error estimate is damped by it: too large a J would hide errors.
  static constexpr bool is_promised = Matrix::is_promised;

  ShiftedStages(const Plain& y, Rhs& rhs, const auto& solver) : options_{solver.options} { resize(y, rhs); }
  void resize(const Plain& y, Rhs& rhs) {
    matrix_.resize(y, rhs);  // may throw, so it comes first
    lanes_.resize(unknowns<S>(y));
    if constexpr (is_promised) check_.resize(y);
    one_.assign(static_cast<std::size_t>(unknowns<S>(y)), {});
  }
  /// Forgets what solves have left.
  void forget() { matrix_.drop(); }
  /// Forgets all that was made for this force.
  void reset() {
    matrix_.forget();
    if constexpr (is_promised) check_.begin();
  }
  /// Forgets the matrix's pattern, too: the state after construction.
  void forget_unsaved() {
    matrix_.forget_pattern();
    if constexpr (is_promised) check_.begin();
    if constexpr (requires { lanes_.forget_pattern(); }) lanes_.forget_pattern();
  }
  static void forget_force() {}

  [[nodiscard]] bool has_jacobian() const { return matrix_.has_jacobian(); }
  /// J at (t, y). Differences start from psi, which is Ψ there.
  [[nodiscard]] Outcome tangent(Rhs& rhs, Scalar t, Scalar dt, const Plain& y, const Rate& psi,
                                const SolveTolerance<Plain>& allowed) {
    matrix_.drop();
    const Gamma<Scalar> gamma{dt, dt};
    matrix_.begin(gamma, Scalar{0});
    if constexpr (is_promised) check_.count();
    return matrix_.linearize(rhs, gamma, t, y, psi, options_, allowed);
  }
  /// All W_l of the J at hand.
  [[nodiscard]] Outcome factorize(Rhs& rhs, const Shift& shift, const auto& masses) {
    mass_ = shift.mass.re[0];
    force_ = shift.force;
    return lanes_.factorize(matrix_.system(), masses, shift, rhs.statistics());
  }
  /// (M − γJ) x = b, in place, for first-order states: by the first lane, whose γ = h/λ is real.
  [[nodiscard]] Outcome solve(Rhs& rhs, Scalar /*gamma*/, Plain& x) {
    ++rhs.statistics().solves;
    solve_first(mass_, [&](auto&& f) { for_each_number(f, Blocks<S>::solved(x)); });
    return Outcome::success;
  }
  /// Whether J, made at (t, y), is the force's own there (tangent_check.hpp): some of the matrices only. Writes Ψ to psi.
  /// @param gamma  h/λ of the first lane, whose factors are at hand
  [[nodiscard]] Outcome check(Rhs& rhs, Scalar gamma, Scalar t, const Plain& y, Rate& psi) {
    if constexpr (is_promised) {
      if (!check_.is_due()) return Outcome::success;
      rhs.evaluate_into(t, y, psi);
      --rhs.statistics().force_calls;
      ++rhs.statistics().checks;
      if (first_non_finite(Rate::blocks(std::as_const(psi)))) return Outcome::non_finite_force;
      const Outcome outcome = check_.look(rhs, *this, options_, Gamma<Scalar>{gamma, gamma}, t, y, psi);
      if (outcome != Outcome::success) reset();
      return outcome;
    }
    return Outcome::success;
  }
  /// Solves for numbers, for TangentCheck.
  [[nodiscard]] Outcome solve(auto& x, const NewtonOptions&, Statistics&) {
    solve_first(mass_, [&x](auto&& f) {
      for (Index i = 0; i < x.size(); ++i) f(static_cast<std::size_t>(i), x[i]);
    });
    return Outcome::success;
  }
  /// x ← W_0⁻¹ x, of the first lane alone
  void solve_real(auto& x) {
    solve_first(force_, [&x, this](auto&& f) {
      for (std::size_t i = 0; i < one_.size(); ++i) f(i, x[i]);
    });
  }
  /// x ← W⁻¹ x
  void solve_in_place(typename Shift::Number* x) { lanes_.solve_in_place(x); }
  /// out += factor K x, x of the positions
  void add_position_product(Scalar factor, const auto& x, auto& out) {
    lanes_.add_position_product(matrix_.system(), factor, x, out);
  }

  [[nodiscard]] const char* solver_name() const { return matrix_.name(); }

 private:
  /// x ← by W⁻¹ x of the first lane's factors, which are those of mass_ (M − γC − γ²K) and of force_ W_0. for_each(f) calls f(i, x_i).
  void solve_first(Scalar by, auto&& for_each) {
    using Real = typename Shift::Real;
    for_each([this, by](std::size_t i, Scalar& x) {
      const Scalar first[lanes]{by * x};
      one_[i] = {Real::load(first), Real{Scalar{0}}};
    });
    lanes_.solve_in_place(one_.data());
    for_each([this](std::size_t i, Scalar& x) { x = one_[i].re[0]; });
  }

  NewtonOptions options_;
  [[no_unique_address]] Only<is_promised, TangentCheck<S, Rhs>> check_;
  Matrix matrix_;
  Lanes lanes_;
  std::vector<typename Shift::Number> one_;  // a right-hand side
  Scalar mass_{1}, force_{1};                // of the first lane's shift
};

template <State S, class Rhs, class LinearSolver>
struct StagesFor<S, Rhs, LinearSolver, true> {
  using type = ShiftedStages<S, Rhs, LinearSolver>;
};

}}  // namespace phistep::PHISTEP_ABI
