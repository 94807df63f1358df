/// @file
/// Newton's increment and matrix for fields: increment.hpp and linearisation.hpp where the library sees no number and W
/// belongs to the user's solver (FieldSolver).
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "phistep/base/facts/implicit_solver.hpp"
#include "phistep/base/machine/only.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/outcome/statistics.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/ranks.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/base/version.hpp"
#include "phistep/step/equation/gamma.hpp"
#include "phistep/step/solve/increment.hpp"
#include "phistep/step/solve/linearisation.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// What solves the linear equations of a field: a class of the user's, or of an adapter. J never leaves it, nor does
// W = M − γ_f C − γ_f γ_d K, with C = ∂Ψ/∂v and K = ∂Ψ/∂r (of a first-order field W = M − γ_f J). All its functions are
// collective.

/// @tparam S  a field, or a motion of two
template <class Solver, class S>
concept FieldSolver = FieldState<S> && std::copyable<Solver> && Solver::is_field_solver &&
    requires(Solver& one, const Solver& done, ScalarOf<S> t, const Gamma<ScalarOf<S>>& gamma,
             typename UnknownsOf<S>::type& x, const typename UnknownsOf<S>::type& y) {
  requires requires {
    { one.linearise(t, y) } -> std::same_as<Outcome>;
  } ||  // J at (t, y)
      (Blocks<S>::drifts && requires {
        { one.linearise(t, y, y) } -> std::same_as<Outcome>;
      });                                             // K and C at (t, r, v)
  { one.factorize(gamma) } -> std::same_as<Outcome>;  // W, and what its solves need
  {
    one.solve(x, double{})
    } -> std::same_as<Outcome>;  // x ← W⁻¹ x to that relative residual, 0: its own choice; x stays where it fails
  { done.iterations() } -> std::convertible_to<std::int64_t>;  // of the last solve
  { done.name() } -> std::convertible_to<const char*>;
};

/// Y = b + w in all components: no reduction tells where w cancels b (Y ≪ b), and where it does digits are lost.
template <FieldState S>
class Increment<S> {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Unknown = typename UnknownsOf<S>::type;
  static constexpr bool drifts = Blocks<S>::drifts;

  Unknown base;   ///< b
  Unknown w;      ///< Y − b
  Unknown delta;  ///< the residual before the linear solve, the correction after it

  void resize(const Plain& y) {
    for (Unknown* x : {&base, &w, &delta, &last_move_}) set_zero_like(*x, solved(y));
    if constexpr (drifts) base_r_ = position_of<S>(y);
  }
  void begin(const Plain& b, Scalar gamma_drift) {
    base = solved(b);
    if constexpr (drifts) base_r_ = position_of<S>(b);
    gamma_drift_ = gamma_drift;
  }
  /// Y.solved = guess.solved; r follows from v.
  void start(Plain& Y, const Plain& guess) {
    w = solved(guess) - base;
    place(Y);
  }
  void move(Plain& Y) {
    last_move_ = delta;
    w += delta;
    place(Y);
  }
  /// Takes back half of the last move.
  void retreat(Plain& Y) {
    last_move_ *= Scalar{0.5};
    undo(Y);
  }
  void undo(Plain& Y) {
    w -= last_move_;
    place(Y);
  }
  /// Of the last move, as the solver's options have it, and in the norm of a controlled run. One reduction.
  [[nodiscard]] Correction size(const Plain& Y, double /*drift_share*/, const NewtonOptions& options) const {
    if (options.rtol > 0) {
      const double rtol = solve_rtol(options.rtol), atol = rtol * options.atol / options.rtol;
      return norm(Unknown::Ops::square(last_move_.handle(), solved(Y).handle(), base.handle(),
                                       static_cast<Scalar>(atol), static_cast<Scalar>(rtol)));
    }
    const auto here = [](const Unknown& x) { return static_cast<double>(Unknown::Ops::largest_here(x.handle())); };
    double all[] = {here(last_move_), here(solved(Y)), here(base)};
    Unknown::Ops::greatest(base.handle(), all);
    const double of = all[0];
    if (of == 0) return {};
    return {relative_size<Scalar>(of, all[1]), relative_size<Scalar>(of, std::max(all[1], all[2])), of};
  }
  [[nodiscard]] Correction size(const Plain&, const SolveTolerance<Plain>& allowed) const {
    return norm(Unknown::Ops::square(last_move_.handle(), solved(*allowed.weight).handle()));
  }
  [[nodiscard]] static double drift_size(const Plain&, double) { return 0; }

 private:
  [[nodiscard]] static auto& solved(auto& y) { return std::get<0>(Blocks<S>::solved(y)); }
  [[nodiscard]] Correction norm(double mine) const {
    Unknown::Ops::total(base.handle(), std::span<double>{&mine, 1});
    const double all = std::sqrt(mine / std::max(1.0, static_cast<double>(last_move_.size())));
    return {all, all, all};
  }
  /// Y = b + w, r = b.r + γ_d v
  void place(Plain& Y) {
    solved(Y) = base + w;
    if constexpr (drifts) position_of<S>(Y) = base_r_ + gamma_drift_ * velocity_of<S>(Y);
  }

  Unknown last_move_;
  [[no_unique_address]] Only<drifts, Unknown> base_r_;
  Scalar gamma_drift_{};
};

/// W of the user's solver: kept while it serves, its work counted. A failure on one rank reaches all ranks with the next
/// reduction that the step needs anyway: the rank's share of it is then NaN.
template <FieldState S, class Rhs, class Solver, bool position, bool stages, bool shifted, bool iterated>
class Linearisation<S, Rhs, Solver, position, stages, shifted, iterated> {
  static_assert(
      FieldSolver<Solver, S>,
      "phistep: the implicit steps of a field need a linear solver of its kind: newton(PetscSolver{...}), or a "
      "class as phistep/embed/field_linearisation.hpp describes it");

 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  using Rate = RateOf<S>;
  using Unknown = typename UnknownsOf<S>::type;
  static constexpr bool matrix_free = false, analytic = false, patterned = false, takes_differences = false;
  static constexpr bool is_promised = Rhs::Traits::is_affine;
  static constexpr bool follows_tolerance = true, is_iterative = true, solves_in_registers = false;
  static constexpr bool has_K = Rhs::drifts && position, has_C = Rhs::couples_unknowns;

  void take(const auto& solver) { solver_.emplace(solver.linear); }
  void resize(const Plain& /*y*/, Rhs& rhs) {
    held_ = rhs.held();
    mass_ = static_cast<double>(std::get<0>(rhs.masses())[0]);
    drop();
  }
  void begin(const Gamma<Scalar>& gamma, Scalar within) {
    scale_ = Scalar{1};
    if (!has_factors_ || gamma == factored_) return;
    const Scalar scale = correction_scale(gamma, factored_, within, has_K && !has_C);
    if (scale == 0) has_factors_ = false;
    else scale_ = scale;
  }
  [[nodiscard]] double staleness(const Gamma<Scalar>& gamma) const {
    return has_factors_ ? std::abs(static_cast<double>(gamma.force / factored_.force) - 1) : 0;
  }
  void drop() { has_jacobian_ = has_factors_ = false; }
  void forget_solves() { drop(); }
  void forget() { drop(); }
  void forget_pattern() { drop(); }
  [[nodiscard]] bool has_jacobian() const { return has_jacobian_; }
  [[nodiscard]] bool has_factors() const { return has_factors_; }
  [[nodiscard]] bool has_factors_for(const Gamma<Scalar>& gamma) const { return has_factors_ && gamma == factored_; }

  [[nodiscard]] Outcome refresh(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar t, const Plain& Y, const Rate& psi,
                                const NewtonOptions& options, const SolveTolerance<Plain>& allowed) {
    if (!has_jacobian_)
      if (const Outcome bad = linearise(rhs, gamma, t, Y, psi, options, allowed); failed(bad)) return bad;
    return factorize(rhs, gamma, t, Y, psi, options);
  }
  [[nodiscard]] Outcome linearise(Rhs& rhs, const Gamma<Scalar>& /*gamma*/, Scalar t, const Plain& Y,
                                  const Rate& /*psi*/, const NewtonOptions& /*options*/,
                                  const SolveTolerance<Plain>& /*allowed*/) {
    ++rhs.statistics().jacobians;
    drop();
    run([&] {
      return std::apply([&](const auto&... block) { return solver_->linearise(t, block...); }, Blocks<S>::all(Y));
    });
    const Outcome outcome = told(Y);
    has_jacobian_ = !failed(outcome);
    return outcome;
  }
  [[nodiscard]] Outcome factorize(Rhs& rhs, const Gamma<Scalar>& gamma, Scalar /*t*/, const Plain& /*Y*/,
                                  const Rate& /*psi*/, const NewtonOptions& /*options*/) {
    ++rhs.statistics().factorizations;
    run([&] { return solver_->factorize(gamma); });
    is_told_ = false;
    has_factors_ = true;
    factored_ = gamma;
    scale_ = Scalar{1};
    return Outcome::success;
  }
  /// x ← W⁻¹ x. @param allowed  of a controlled run: rules where the options don't
  [[nodiscard]] Outcome solve(Unknown& x, const NewtonOptions& options, Statistics& statistics,
                              const SolveTolerance<Plain>& allowed = {}) {
    if (const Outcome bad = solve_untold(x, options, statistics, allowed); failed(bad)) return bad;
    return told(x);
  }
  /// The same, where the next reduction, or the end of the step, tells all ranks of a failure: x is then NaN where it failed.
  /// @param square  Σ (x_i weight_i)² over all ranks, which is finite; negative: not known
  [[nodiscard]] Outcome solve_untold(Unknown& x, const NewtonOptions& options, Statistics& statistics,
                                     const SolveTolerance<Plain>& allowed, double square = -1) {
    ++statistics.solves;
    double rtol = options.linear_rtol;
    const bool is_sized = sizes(options, allowed);
    if (!is_sized && (stages || !is_told_)) {
      if (!Unknown::Ops::is_finite_here(x.handle())) held_->note(Outcome::non_finite_state);
      if (const Outcome bad = told(x); failed(bad)) return bad;
    }
    if (is_sized) {
      if (square < 0) {
        square = square_here(x, allowed);
        Unknown::Ops::total(x.handle(), std::span<double>{&square, 1});
        if (!std::isfinite(square))
          if (const Outcome bad = told(x); failed(bad)) return bad;
        if (std::isnan(square)) return Outcome::non_finite_state;
      } else if (!is_told_) {
        if (const Outcome bad = told(x); failed(bad)) return bad;
      }
      // A residual of that size in the run's weights, where x is about W⁻¹'s largest, M⁻¹, times as large.
      const double size = std::sqrt(square / static_cast<double>(x.size())) / mass_;
      const double share = inexact_share * allowed.target;
      rtol = std::clamp(size > 0 ? share / size : 0.5, 1e-12, 0.5);
    }
    run([&] { return solver_->solve(x, rtol); });
    if (failed(held_->found())) x.poison();
    statistics.linear_iterations += solver_->iterations();
    if (scale_ != Scalar{1}) x *= scale_;
    is_told_ = true;  // of the factors
    return Outcome::success;
  }
  /// Whether the tolerance of a solve follows the size of its right-hand side …
  [[nodiscard]] static bool sizes(const NewtonOptions& options, const SolveTolerance<Plain>& allowed) {
    return allowed.target > 0 && (stages || options.linear_rtol == 0);
  }
  /// … and this rank's share of the latter's square: NaN where this rank knows of a failure.
  [[nodiscard]] double square_here(const Unknown& x, const SolveTolerance<Plain>& allowed) const {
    if (failed(held_->found())) return std::numeric_limits<double>::quiet_NaN();
    return Unknown::Ops::square(x.handle(), std::get<0>(Blocks<S>::solved(*allowed.weight)).handle());
  }
  /// What all ranks make of what each has found; collective.
  [[nodiscard]] Outcome told(const auto& ranks) {
    const Outcome all = agreed(ranks, held_->found());
    held_->told();
    is_told_ = true;
    if (failed(all)) has_factors_ = false;
    return all;
  }
  template <class X>
  void add_position_product(Scalar, const X&, auto&) const {
    static_assert(
        !sizeof(X),
        "phistep: Rosenbrock schemes multiply with dPsi/dr, which a field's solver doesn't: take trapezoidal, "
        "tr_bdf2 or velocity_verlet for a motion of fields");
  }
  [[nodiscard]] static bool reached_too_far(const Plain&, const Unknown&) { return false; }
  [[nodiscard]] static std::int64_t singular_particle() { return -1; }
  [[nodiscard]] static double drift_share() { return 0; }
  [[nodiscard]] static double magnitude() { return 0; }
  [[nodiscard]] const char* name() const { return solver_->name(); }

 private:
  /// f, a function of the solver's, on this rank.
  void run(auto&& f) {
    held_->run([&] { held_->note(f()); }, [] {});
  }

  std::optional<Solver> solver_;
  std::shared_ptr<HeldException> held_;  // that of the right-hand side
  double mass_ = 1;
  Gamma<Scalar> factored_{};
  Scalar scale_{1};
  bool has_jacobian_ = false, has_factors_ = false;
  bool is_told_ = true;  // all ranks know what the last factorization has come to
};

}}  // namespace phistep::PHISTEP_ABI
